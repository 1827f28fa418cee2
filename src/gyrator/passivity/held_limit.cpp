#include "gyrator/passivity/held_limit.hpp"

#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/frequency_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();

// The device without its analog loop, and the loop around it at any k and d.
class HeldLoop {
 public:
  explicit HeldLoop(const Device& device) : device_(device), model_(without_loop(device)) {
    const HeldImpedance& held = *find_held_impedance(device);
    if (held.bandwidth_hz) time_constant_ = 1 / (2 * std::numbers::pi * *held.bandwidth_hz);
    // The limit at zero and at infinity, and dense enough between poles that a minimum between
    // points is found from its neighbours.
    double slowest = infinity;
    double fastest = 0;
    const auto count = [&](double rate) {
      if (!(rate > 0)) return;
      slowest = std::min(slowest, rate);
      fastest = std::max(fastest, rate);
    };
    for (const auto& pole : model_.poles()) count(std::abs(pole));
    if (time_constant_ > 0) count(1 / time_constant_);
    if (fastest == 0) slowest = fastest = 1;
    for (double omega = 1e-3 * slowest; omega < 1e4 * fastest; omega *= 1.02)
      grid_.push_back(omega);
    for (const auto& pole : model_.poles()) {
      if (pole.imag() > 0) add_resonance(grid_, pole);
    }
    std::sort(grid_.begin(), grid_.end());
    for (const double omega : grid_) responses_.push_back(model_.at(omega));
  }

  // Least Re Z over frequency against the size of Z there.
  Minimum find_least_damping(double stiffness, double damping) {
    std::vector<double> values;
    for (const PortResponse& r : responses_) values.push_back(damping_at(r, stiffness, damping));
    return find_minimum(grid_, values, [&](double omega) {
      return damping_at(model_.at(omega), stiffness, damping);
    });
  }

  bool is_stable(double stiffness, double damping) const {
    Device device = device_;
    for (auto& part : device.drive.damping) {
      if (auto* held = std::get_if<HeldImpedance>(&part)) {
        held->stiffness = stiffness;
        held->damping = damping;
      }
    }
    return !find_unstable_pole(build_device_network(device, FreeOperator{})) &&
           !find_unstable_pole(build_device_network(device, ClampedOperator{}));
  }

 private:
  static Device without_loop(Device device) {
    std::erase_if(device.drive.damping,
                  [](const Damping& d) { return std::holds_alternative<HeldImpedance>(d); });
    return device;
  }

  static void add_resonance(std::vector<double>& grid, Complex pole) {
    for (int i = -20; i <= 20; ++i) {
      const double omega = pole.imag() + 0.2 * i * std::abs(pole.real());
      if (omega > 0) grid.push_back(omega);
    }
  }

  double damping_at(const PortResponse& r, double stiffness, double damping) const {
    const Complex s(0, r.omega);
    const Complex loop = (stiffness / s + damping) / (1.0 + s * time_constant_);
    const Complex z =
        r.impedance + r.actuation * r.sensor_path * loop / (1.0 + loop * r.blocked_motion);
    // Rounding of Re Z comes from the size of the impedance.
    return z.real() + 1e-14 * std::abs(z);
  }

  const Device& device_;
  PortModel model_;
  double time_constant_ = 0;
  std::vector<double> grid_;
  std::vector<PortResponse> responses_;
};

}  // namespace

const HeldImpedance* find_held_impedance(const Device& device) {
  for (const auto& damping : device.drive.damping) {
    if (const auto* held = std::get_if<HeldImpedance>(&damping)) return held;
  }
  return nullptr;
}

StiffnessLimit find_held_stiffness_limit(const Device& device, double damping) {
  HeldLoop loop(device);
  const auto passes = [&](double stiffness) {
    return loop.find_least_damping(stiffness, damping).value > 0 &&
           loop.is_stable(stiffness, damping);
  };
  const Minimum alone = loop.find_least_damping(0, damping);
  if (!passes(0)) return {0, false, alone.omega / (2 * std::numbers::pi)};
  // From far below what the inertia alone would call a fast oscillation to far beyond.
  const double unit = device.mechanics.inertia;
  double low = 0;
  double high = 1e-3 * unit;
  while (passes(high)) {
    low = high;
    high *= 4;
    if (high > 1e18 * unit) return {infinity, true, 0};
  }
  while (high - low > 1e-10 * high) {
    const double middle = (low + high) / 2;
    (passes(middle) ? low : high) = middle;
  }
  return {low, true, loop.find_least_damping(high, damping).omega / (2 * std::numbers::pi)};
}

}  // namespace gyrator
