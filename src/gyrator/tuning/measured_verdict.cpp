#include "gyrator/tuning/measured_verdict.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/random_stream.hpp"
#include "gyrator/core/statistics.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/frequency_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr std::size_t fewest_frequencies = 4;
constexpr double confidence = 0.99;

// A complex ratio at some frequencies, and what is made of it in between and beyond.
class Ratio {
 public:
  void add(double omega, Complex ratio) {
    double phase = std::arg(ratio);
    if (!phase_.empty()) phase += 2 * pi * std::round((phase_.back() - phase) / (2 * pi));
    omega_.push_back(omega);
    size_.push_back(std::log(std::abs(ratio)));
    phase_.push_back(phase);
  }

  Complex at(double omega) const {
    if (omega_.empty()) return 1;
    if (omega <= omega_.front())
      return std::polar(std::exp(size_.front()), phase_.front() * omega / omega_.front());
    if (omega >= omega_.back()) {
      const double left = 1 - std::log2(omega / omega_.back());
      return left <= 0 ? 1.0 : std::polar(std::exp(left * size_.back()), left * phase_.back());
    }
    const auto above = std::upper_bound(omega_.begin(), omega_.end(), omega);
    const auto i = static_cast<std::size_t>(above - omega_.begin());
    const double part = std::log(omega / omega_[i - 1]) / std::log(omega_[i] / omega_[i - 1]);
    return std::polar(std::exp(std::lerp(size_[i - 1], size_[i], part)),
                      std::lerp(phase_[i - 1], phase_[i], part));
  }

 private:
  std::vector<double> omega_, size_, phase_;
};

struct Limits {
  double margin = std::numeric_limits<double>::infinity();
  double omega = 0;
  double stiffness = std::numeric_limits<double>::infinity();
};

// Up to which K D = R + 2 Re{(K + B V) c} + |K + B V|^2 g stays positive, c and g scaled (disk-3).
double find_stiffness(const DiskPoint& disk, Complex damping_law) {
  const double g = disk.scaled_gap;
  const double linear = 2 * disk.scaled_center.real() + 2 * damping_law.real() * g;
  const double constant = disk.damping_margin(damping_law);
  if (!(constant > 0)) return 0;
  const double discriminant = linear * linear - 4 * g * constant;
  if (discriminant < 0) return std::numeric_limits<double>::infinity();
  // The smallest positive root, without a difference of equal numbers.
  const double q = -(linear + std::copysign(std::sqrt(discriminant), linear)) / 2;
  double lowest = std::numeric_limits<double>::infinity();
  for (const double root : {q / g, constant / q})
    if (root > 0) lowest = std::min(lowest, root);
  return lowest;
}

Tone shake(const Tone& tone, RandomStream& random) {
  Tone shaken = tone;
  for (Phasor* p : {&shaken.command, &shaken.current, &shaken.voltage, &shaken.velocity})
    p->value += p->deviation * Complex(random.normal(), random.normal());
  return shaken;
}

class Judge {
 public:
  Judge(const PassivityModel& model, const DriveMeasurement& measurement)
      : model_(model), measurement_(measurement), port_(model.device) {
    check();
    period_ = model.sampling.period.to_double();
    const auto& wall = std::get<VirtualWall>(model.controller.law);
    wall_ = {wall.stiffness, wall.damping};
    velocity_ = make_wall_law({0, 1, wall.velocity}, period_);
    gain_ = find_amplifier_gain(model.device);
  }

  MeasuredVerdict judge(std::uint64_t seed, int draws) {
    MeasuredVerdict v;
    const Limits nominal = limits_of(measurement_, GridDensity::fine);
    v.margin = nominal.margin;
    v.worst_frequency_hz = nominal.omega / (2 * pi);
    v.max_stiffness = nominal.stiffness;
    worst_omega_ = nominal.omega;
    v.modelled_max_stiffness = limits_with({}, {}, GridDensity::fine).stiffness;
    describe_points(v);

    RandomStream random(seed, 0);
    std::vector<double> margins{v.margin}, stiffnesses{v.max_stiffness};
    std::vector<std::vector<double>> dampings(v.points.size());
    for (int draw = 0; draw < draws; ++draw) {
      DriveMeasurement shaken = measurement_;
      for (auto* tones : {&shaken.bare, &shaken.damped})
        for (Tone& tone : *tones) tone = shake(tone, random);
      const Limits limits = limits_of(shaken, GridDensity::coarse);
      margins.push_back(limits.margin);
      stiffnesses.push_back(limits.stiffness);
      for (std::size_t i = 0; i < dampings.size(); ++i)
        dampings[i].push_back(port_at(shaken, i).first.real());
    }
    v.margin_low = lower_bound(margins);
    v.max_stiffness_low = lower_bound(stiffnesses);
    for (std::size_t i = 0; i < dampings.size() && draws > 0; ++i) {
      std::sort(dampings[i].begin(), dampings[i].end());
      v.points[i].damping_low = find_quantile(dampings[i], (1 - confidence) / 2);
      v.points[i].damping_high = find_quantile(dampings[i], (1 + confidence) / 2);
    }
    const DiscreteStateSpace law = make_contact_law(model_.controller, period_);
    const double radius = compute_loop_radius(model_.device, FreeOperator{}, model_.sampling, law);
    v.passive = v.margin > 0 && v.margin_low > 0 && radius <= 1 + stability_tolerance;
    return v;
  }

 private:
  const Motor& motor() const { return *model_.device.drive.motor; }

  void check() const {
    check_measurable(model_);
    const auto& [mode, delay, bare, damped] = measurement_;
    if (bare.size() != damped.size() || bare.size() < fewest_frequencies)
      throw Error(ErrorCode::bad_input, "measurement",
                  fmt::format("{} and {} frequencies: as many of both, and at least {}",
                              bare.size(), damped.size(), fewest_frequencies));
  }

  // Z_e and A of a measured frequency, the delay taken out.
  DrivePort drive_at(const DriveMeasurement& m, std::size_t i) const {
    DrivePort port = find_drive_port(m.mode, motor().torque_constant, gain_,
                                     find_drive_point(m.mode, motor(), m.bare[i], m.damped[i]));
    port.actuation *= std::polar(1.0, 2 * pi * port.frequency_hz * m.delay);
    return port;
  }

  Complex mechanics_at(double omega) const {
    return {model_.device.mechanics.damping, omega * model_.device.mechanics.inertia};
  }

  std::pair<Complex, Complex> port_at(const DriveMeasurement& m, std::size_t i) const {
    const DrivePort port = drive_at(m, i);
    return {mechanics_at(2 * pi * port.frequency_hz) + port.impedance, port.actuation};
  }

  Limits limits_of(const DriveMeasurement& m, GridDensity density) {
    Ratio impedance, actuation;
    for (std::size_t i = 0; i < m.damped.size(); ++i) {
      const DrivePort port = drive_at(m, i);
      const double omega = 2 * pi * port.frequency_hz;
      const PortResponse model = port_.at(omega);
      actuation.add(omega, port.actuation / model.actuation);
      const Complex electrical = model.impedance - mechanics_at(omega);
      // A drive without damping has none to compare with.
      if (std::abs(electrical) > 1e-9 * std::abs(model.impedance))
        impedance.add(omega, port.impedance / electrical);
    }
    return limits_with(impedance, actuation, density);
  }

  Limits limits_with(const Ratio& impedance, const Ratio& actuation, GridDensity density) const {
    AliasedDisk disk(model_.device, model_.sampling, [&](PortResponse& r) {
      const Complex mechanics = mechanics_at(r.omega);
      r.impedance = mechanics + impedance.at(r.omega) * (r.impedance - mechanics);
      r.actuation *= actuation.at(r.omega);
    });
    Limits limits;
    std::vector<double> grid = make_judging_grid(port_.poles(), period_, density);
    if (worst_omega_ > 0) grid.push_back(worst_omega_);
    for (const double omega : grid) {
      const DiskPoint point = disk.at(omega);
      const Complex V = wall_.damping * velocity_.response(std::polar(1.0, omega * period_));
      const double margin = point.damping_margin(wall_.stiffness + V);
      if (std::isnan(margin))
        throw Error(ErrorCode::numerical, "measurement",
                    fmt::format("no number comes of it at {:.4g} Hz", omega / (2 * pi)));
      if (margin < limits.margin) {
        limits.margin = margin;
        limits.omega = omega;
      }
      limits.stiffness = std::min(limits.stiffness, find_stiffness(point, V));
    }
    if (disk.least_damping().active) {
      limits.stiffness = 0;
      if (disk.least_damping().value < limits.margin) {
        limits.margin = disk.least_damping().value;
        limits.omega = disk.least_damping().omega;
      }
    }
    return limits;
  }

  void describe_points(MeasuredVerdict& v) {
    for (std::size_t i = 0; i < measurement_.damped.size(); ++i) {
      MeasuredPoint point;
      point.frequency_hz = measurement_.damped[i].frequency_hz;
      std::tie(point.impedance, point.actuation) = port_at(measurement_, i);
      const PortResponse model = port_.at(2 * pi * point.frequency_hz);
      point.modelled_impedance = model.impedance;
      point.modelled_actuation = model.actuation;
      point.damping_low = point.damping_high = point.impedance.real();
      point.winding_resistance =
          find_drive_point(measurement_.mode, motor(), measurement_.bare[i], measurement_.damped[i])
              .winding.real();
      v.points.push_back(point);
    }
  }

  static double lower_bound(std::vector<double>& values) {
    std::sort(values.begin(), values.end());
    return find_quantile(values, 1 - confidence);
  }

  const PassivityModel& model_;
  const DriveMeasurement& measurement_;
  PortModel port_;
  double period_ = 0, gain_ = 1;
  double worst_omega_ = 0;  // of the nominal measurement, which every other is judged at too
  WallValues wall_;
  DiscreteStateSpace velocity_;
};

}  // namespace

void check_measurable(const PassivityModel& model) {
  const auto refuse = [](const char* place, const char* message) {
    throw Error(ErrorCode::bad_input, place, message);
  };
  const Device& device = model.device;
  if (!device.drive.motor) refuse("motor", "none: a measured drive has one");
  if (device.mechanics.transmission)
    refuse("mechanics/transmission",
           "a measured drive is judged with what it carries rigid with it");
  if (device.sensor != SensorLocation::port && device.sensor != SensorLocation::motor)
    refuse("sensor/location", "a measured drive is judged with its position sensed");
  if (!std::holds_alternative<VirtualWall>(model.controller.law))
    refuse("controller/kind", "only a virtual_wall can be judged on a measured drive");
}

MeasuredVerdict judge_measured(const PassivityModel& model, const DriveMeasurement& measurement,
                               std::uint64_t seed, int draws) {
  return Judge(model, measurement).judge(seed, draws);
}

}  // namespace gyrator
