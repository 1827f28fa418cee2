#include "gyrator/mechanics/stability.hpp"

#include "gyrator/circuits/reduction.hpp"
#include "gyrator/circuits/state_space.hpp"
#include "gyrator/core/error.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <fmt/core.h>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Poles of the network and the elements that take part in them.
class Modes {
 public:
  explicit Modes(const DeviceNetwork& device)
      : network_(device.network),
        equations_(device.network),
        reduction_(reduce(equations_.descriptor())) {
    if (reduction_.A.rows() == 0) return;
    MatrixXd balanced = reduction_.A;
    const VectorXd scale = balance(balanced);
    const Eigen::EigenSolver<MatrixXd> solver(balanced);
    poles_ = solver.eigenvalues();
    vectors_ = scale.asDiagonal() * solver.eigenvectors();
  }

  Index count() const { return poles_.size(); }
  const Eigen::VectorXcd& poles() const { return poles_; }

  // The element that stores most of the mode's energy.
  std::string main_element(Index mode) const {
    const Eigen::VectorXcd unknowns = reduction_.recover_state * vectors_.col(mode);
    std::string name;
    double most = -1;
    const auto& elements = network_.elements();
    for (int e = 0; e < static_cast<int>(elements.size()); ++e) {
      const Element& element = elements[static_cast<std::size_t>(e)];
      double energy = -1;
      if (const auto* c = std::get_if<Capacitor>(&element.law)) {
        energy = c->capacitance * std::norm((equations_.across(ElementId{e}).x * unknowns)(0));
      } else if (const auto* l = std::get_if<Inductor>(&element.law)) {
        energy = l->inductance * std::norm((equations_.through(ElementId{e}).x * unknowns)(0));
      }
      if (energy <= most || element.role != Role::device) continue;
      most = energy;
      name = element.name;
    }
    return name;
  }

 private:
  const Network& network_;
  NetworkEquations equations_;
  Reduction reduction_;
  Eigen::VectorXcd poles_;
  Eigen::MatrixXcd vectors_;
};

ResistanceCancellation* find_cancellation(Device& device) {
  for (auto& damping : device.drive.damping) {
    if (auto* cancellation = std::get_if<ResistanceCancellation>(&damping)) return cancellation;
  }
  return nullptr;
}

bool has_back_emf_feedback(const Device& device) {
  for (const auto& damping : device.drive.damping) {
    if (std::holds_alternative<BackEmfDamping>(damping)) return true;
  }
  return false;
}

// Where `stable`, true at `from`, becomes false on the way to `to`; none if it never does.
template <class Stable>
std::optional<double> find_edge(const Stable& stable, double from, double to) {
  if (!stable(from)) return from;
  if (stable(to)) return std::nullopt;
  while (std::abs(to - from) > 1e-12 * std::abs(to) + 1e-12) {
    const double middle = (from + to) / 2;
    if (middle == from || middle == to) break;
    (stable(middle) ? from : to) = middle;
  }
  return from;
}

StabilityEdge find_edge_held(const Device& device, const Operator& held_by, double gain) {
  const auto is_stable = [&](const Device& varied) {
    return !find_unstable_pole(build_device_network(varied, held_by, gain));
  };
  StabilityEdge edge;
  Device varied = device;
  const Motor& motor = *device.drive.motor;
  if (auto* cancellation = find_cancellation(varied)) {
    const auto stable = [&](double resistance) {
      cancellation->resistance = resistance;
      return is_stable(varied);
    };
    // Far beyond all that the loop can lose.
    double most = std::max(motor.resistance, find_cancellation(varied)->resistance);
    while (stable(most) && most < 1e9 * motor.resistance) most *= 2;
    edge.cancellation = find_edge(stable, 0, most);
  }
  varied = device;
  const auto stable_at = [&](double rise) {
    varied.drive.motor->temperature_rise = rise;
    return is_stable(varied);
  };
  const double now = motor.temperature_rise;
  if (motor.temperature_coefficient > 0) {
    const double without_resistance = -(1 - 1e-6) / motor.temperature_coefficient;
    edge.coldest_rise = find_edge(stable_at, now, without_resistance);
    edge.hottest_rise = find_edge(stable_at, now, std::max(now, hottest_rise));
  }
  return edge;
}

// The damping that may supply energy and without which the device is stable, if there is one.
std::optional<std::size_t> find_active_culprit(const Device& device, const Operator& held_by) {
  for (std::size_t i = 0; i < device.drive.damping.size(); ++i) {
    const Damping& damping = device.drive.damping[i];
    if (!std::holds_alternative<NetlistDamping>(damping) &&
        !std::holds_alternative<BackEmfDamping>(damping)) {
      continue;
    }
    Device without = device;
    without.drive.damping.erase(without.drive.damping.begin() + static_cast<std::ptrdiff_t>(i));
    if (!find_unstable_pole(build_device_network(without, held_by))) return i;
  }
  return std::nullopt;
}

[[noreturn]] void throw_cancellation_exceeded(const Device& device, const std::string& how) {
  std::size_t at = 0;
  while (!std::holds_alternative<ResistanceCancellation>(device.drive.damping[at])) ++at;
  const auto edges = find_stability_edges(device);
  const Motor& motor = *device.drive.motor;
  const auto allowed = [](const StabilityEdge& edge) {
    return edge.cancellation.value_or(INFINITY);
  };
  throw Error(
      ErrorCode::bad_input, fmt::format("damping/{}", at),
      fmt::format(
          "resistance_cancellation of {:.6g} ohm with a winding of {:.6g} ohm (at a "
          "temperature rise of {:.4g} K): {}; it must be below {:.6g} ohm for a clamped and "
          "below {:.6g} ohm for a free port",
          std::get<ResistanceCancellation>(device.drive.damping[at]).resistance,
          motor.warm_resistance(), motor.temperature_rise, how, allowed(edges->clamped),
          allowed(edges->free)));
}

}  // namespace

// Of a device without damping every pole is rounding of zero. What doubles in twenty years is
// stable.
constexpr double slowest_growth = 1e-9;  // [rad/s]

std::optional<UnstablePole> find_unstable_pole(const DeviceNetwork& device) {
  const Modes modes(device);
  if (modes.count() == 0) return std::nullopt;
  Index worst = 0;
  const double largest = modes.poles().real().maxCoeff(&worst);
  const double fastest = modes.poles().cwiseAbs().maxCoeff();
  if (!(largest > std::max(slowest_growth, 1e-9 * fastest))) return std::nullopt;
  return UnstablePole{largest, std::abs(modes.poles()(worst).imag()), modes.main_element(worst)};
}

FastestElement find_fastest_element(const DeviceNetwork& device) {
  const Modes modes(device);
  if (modes.count() == 0) return {};
  Index fastest = 0;
  const double rate = modes.poles().cwiseAbs().maxCoeff(&fastest);
  return {rate, modes.main_element(fastest)};
}

void require_stable_device(const Device& whole) {
  // Whether a held-impedance loop is stable is a question for the verdict.
  Device device = whole;
  std::erase_if(device.drive.damping,
                [](const Damping& d) { return std::holds_alternative<HeldImpedance>(d); });
  for (const Operator& held_by : {Operator{ClampedOperator{}}, Operator{FreeOperator{}}}) {
    const auto pole = find_unstable_pole(build_device_network(device, held_by));
    if (!pole) continue;
    const bool clamped = std::holds_alternative<ClampedOperator>(held_by);
    const std::string how = fmt::format(
        "the device alone is unstable with the port {}: pole at {:+.4g} {:+.4g}j rad/s (amplitude "
        "doubles every {:.3g} s)",
        clamped ? "clamped" : "free", pole->real, pole->imag, std::numbers::ln2 / pole->real);
    Device copy = device;
    if (find_cancellation(copy)) throw_cancellation_exceeded(device, how);
    if (const auto active = find_active_culprit(device, held_by)) {
      throw Error(
          ErrorCode::bad_input, fmt::format("damping/{}", *active),
          how + "; without this damping it is stable: it supplies more than the rest takes");
    }
    throw Error(ErrorCode::numerical, pole->element,
                how +
                    ": the amplifier's loop and this element oscillate; lower the amplifier's "
                    "bandwidth or add resistance");
  }
}

std::optional<StabilityEdges> find_stability_edges(const Device& device) {
  Device copy = device;
  if (!device.drive.motor) return std::nullopt;
  if (!find_cancellation(copy) && !has_back_emf_feedback(device)) return std::nullopt;
  const double gain = find_amplifier_gain(device);
  return StabilityEdges{find_edge_held(device, ClampedOperator{}, gain),
                        find_edge_held(device, FreeOperator{}, gain)};
}

}  // namespace gyrator
