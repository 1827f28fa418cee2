#include "gyrator/passivity/criteria.hpp"

#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/frequency_grid.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/passivity/virtual_damping.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace gyrator {
namespace {

using std::numbers::pi;

// Changes of Re Z and of A below this are no change.
constexpr double same = 1e-6;

std::string join_reasons(const std::vector<std::string>& reasons) {
  return fmt::format("{}", fmt::join(reasons, "; "));
}

std::vector<std::string> drive_reasons(const Assumptions& a) {
  if (a.reads_wave)
    return {
        "the controller reads a wave, not the position; shown for the same wall computed from the "
        "position"};
  std::vector<std::string> reasons;
  if (a.predicts)
    reasons.emplace_back(
        "the wall is computed from a predicted position; shown for the same wall without "
        "prediction");
  if (!a.ideal_drive) {
    reasons.push_back(fmt::format(
        "the command reaches the shaft through the circuit (A is not 1; it lags by {:.3g} s "
        "at low frequency)",
        a.lag_s));
  }
  if (!a.collocated)
    reasons.emplace_back(a.filtered ? "the sensed position lags behind its filter"
                                    : "the sensor is not at the port");
  if (a.held) reasons.emplace_back("the wall is an analog loop: no sampled law is left to judge");
  return reasons;
}

// The controller's wall, or the one from the position with the values of a wall behind a wave line.
std::optional<VirtualWall> find_textbook_wall(const Controller& controller) {
  if (const auto* wall = std::get_if<VirtualWall>(&controller.law)) return *wall;
  const auto values = find_wall_values(controller);
  if (!values) return std::nullopt;
  return VirtualWall{.stiffness = values->stiffness, .damping = values->damping};
}

double spread(double low, double high) {
  return high > 0 ? (high - low) / high : 0;
}

CriterionResult judge_spring_damper(const VirtualWall& wall, const Assumptions& a,
                                    StiffnessLimits& limits) {
  CriterionResult result;
  result.name = "spring_damper";
  const double b = limits.disk().model().at(limits.grid().front()).impedance.real();
  result.margin = b - (wall.stiffness * limits.disk().period() / 2 + std::abs(wall.damping));
  result.holds = result.margin > 0;
  result.worst_frequency_hz = 0.5 / limits.disk().period();
  result.max_stiffness = limits.find(Criterion::spring_damper, wall.damping).stiffness;
  auto reasons = drive_reasons(a);
  if (!a.constant_damping) reasons.emplace_back("the device's damping depends on frequency");
  if (!a.no_delay) reasons.emplace_back("there is a computation delay");
  const auto* difference = std::get_if<DifferenceEstimator>(&wall.velocity);
  if (wall.damping != 0 && !(difference && difference->window == 1)) {
    reasons.emplace_back("velocity is not the backward difference over one sample");
  }
  result.applies = reasons.empty();
  result.reason = reasons.empty() ? "b > K T/2 + |B| [8.4]" : join_reasons(reasons);
  return result;
}

CriterionResult judge_frequency_dependent(const PassivityModel& model,
                                          const DiscreteStateSpace& law, const Assumptions& a,
                                          StiffnessLimits& limits) {
  CriterionResult result;
  result.name = "frequency_dependent";
  const double period = limits.disk().period();
  const double delay = model.sampling.delay.to_double();
  const auto total = [&](double omega) {
    const auto late = std::polar(1.0, -omega * delay);
    return limits.disk().model().at(omega).impedance.real() +
           compute_virtual_damping(omega, period,
                                   late * law.response(std::polar(1.0, omega * period)));
  };
  std::vector<double> values;
  for (const double omega : limits.grid()) values.push_back(total(omega));
  const Minimum worst = find_minimum(limits.grid(), values, total);
  result.margin = worst.value;
  result.holds = worst.value > 0;
  result.worst_frequency_hz = worst.omega / (2 * pi);
  if (const auto wall = find_wall_values(model.controller)) {
    result.max_stiffness = limits.find(Criterion::frequency_dependent, wall->damping).stiffness;
  }
  auto reasons = drive_reasons(a);
  if (!a.non_decreasing_damping) {
    reasons.push_back(
        fmt::format("the device's damping falls with frequency from {:.3g} Hz", a.falling_from_hz));
  }
  if (!a.whole_delay) reasons.emplace_back("the delay is not a whole number of periods");
  result.applies = reasons.empty();
  result.reason = reasons.empty() ? "Re Z + virtual damping > 0 at every frequency [8.46]"
                                  : join_reasons(reasons);
  return result;
}

CriterionResult judge_quantized_coulomb(const PassivityModel& model, const VirtualWall& wall,
                                        const Assumptions& a, StiffnessLimits& limits) {
  CriterionResult result;
  result.name = "quantized_coulomb";
  const double period = limits.disk().period();
  const double b = limits.disk().model().at(limits.grid().front()).impedance.real();
  const double coulomb = model.device.mechanics.coulomb_friction;
  const double friction_limit = model.quantum > 0 ? 2 * coulomb / model.quantum : INFINITY;
  const double limit = std::min(2 * b / period, friction_limit);
  result.max_stiffness = limit;
  result.margin = (limit - wall.stiffness) * period / 2;
  result.holds = wall.stiffness <= limit;
  auto reasons = drive_reasons(a);
  if (!(model.quantum > 0)) reasons.emplace_back("no encoder quantum is given");
  if (!a.constant_damping) reasons.emplace_back("the device's damping depends on frequency");
  if (!a.no_delay) reasons.emplace_back("there is a computation delay");
  if (wall.damping != 0) reasons.emplace_back("the wall has virtual damping");
  result.applies = reasons.empty();
  result.reason = reasons.empty() ? "K <= min(2 b/T, 2 f_c/quantum) [8.5]" : join_reasons(reasons);
  return result;
}

}  // namespace

DiscreteStateSpace make_textbook_law(const Controller& controller, double period) {
  if (const auto wall = find_textbook_wall(controller)) return make_wall_law(*wall, period);
  if (std::holds_alternative<WaveController>(controller.law)) return make_gain(0);
  return make_contact_law(Controller(controller.law, {}), period);  // any other reads the position
}

Assumptions test_assumptions(const Device& device, const Sampling& sampling, PortModel& model) {
  Assumptions a;
  a.held = find_held_impedance(device) != nullptr;
  a.collocated = build_device_network(device, FreeOperator{}).collocated;
  a.filtered = device.sensor_filter.has_value();
  a.reads_wave = device.sensor == SensorLocation::outgoing_wave;
  a.no_delay = sampling.delay == Rational(0);
  a.whole_delay = split_delay(sampling).rest == 0;

  // To infinity: up to far beyond the fastest pole and the Nyquist frequency.
  const double period = sampling.period.to_double();
  std::vector<double> grid = make_judging_grid(model.poles(), period);
  const double fastest = model.poles().size() > 0 ? model.poles().cwiseAbs().maxCoeff() : 0;
  const double top = 100 * std::max(fastest, pi / period);
  for (double omega = grid.back() * 1.05; omega < top; omega *= 1.05) grid.push_back(omega);

  double highest = 0;
  double lowest = INFINITY;
  for (const double omega : grid) {
    const PortResponse r = model.at(omega);
    const double damping = r.impedance.real();
    // Rounding of Re Z comes from the size of the impedance.
    const double noise = same * std::max(highest, damping) + 1e-12 * std::abs(r.impedance);
    if (damping < highest - noise && a.non_decreasing_damping) {
      a.non_decreasing_damping = false;
      a.falling_from_hz = omega / (2 * pi);
    }
    if (1e-12 * std::abs(r.impedance) < same * std::max(highest, damping)) {
      highest = std::max(highest, damping);
      lowest = std::min(lowest, damping);
    }
    if (std::abs(r.actuation - 1.0) > same) a.ideal_drive = false;
  }
  a.constant_damping = spread(lowest, highest) < same;
  const PortResponse slow = model.at(grid.front());
  a.lag_s = -std::arg(slow.actuation) / slow.omega;
  return a;
}

std::vector<CriterionResult> judge_textbook(const PassivityModel& model, Assumptions assumptions,
                                            StiffnessLimits& limits) {
  assumptions.predicts = std::holds_alternative<PredictiveWall>(model.controller.law);
  const double period = model.sampling.period.to_double();
  std::vector<CriterionResult> results;
  const auto wall = find_textbook_wall(model.controller);
  if (wall) results.push_back(judge_spring_damper(*wall, assumptions, limits));
  results.push_back(judge_frequency_dependent(model, make_textbook_law(model.controller, period),
                                              assumptions, limits));
  if (wall) results.push_back(judge_quantized_coulomb(model, *wall, assumptions, limits));
  return results;
}

}  // namespace gyrator
