#include "gyrator/tuning/settings_choice.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

// Values of the lattice between two, so many and in about the same ratio to one another.
std::vector<double> choose_values(const SettingRange& range, double from, double to, int count) {
  const double low = std::max({from, range.low, range.step > 0 ? range.step : 0.0, 1e-12});
  const double high = std::min(to, range.high);
  std::vector<double> values;
  for (int i = 0; i < count && high >= low; ++i) {
    const double wanted = low * std::pow(high / low, i / std::max(1.0, count - 1.0));
    const double value = snap(wanted, range);
    if (value > 0 && (values.empty() || value > values.back())) values.push_back(value);
  }
  return values;
}

class Chooser {
 public:
  Chooser(const PassivityModel& model, const TuningTarget& target, const RangeOf& range_of)
      : model_(model), target_(target), range_of_(range_of) {
    const auto wall = find_wall_values(model.controller);
    if (!wall)
      throw Error(ErrorCode::bad_input, "controller/kind",
                  "no wall that an amplifier could be tuned for: use virtual_wall");
    wall_ = *wall;
  }

  TuningChoice choose_rc() {
    const SettingRange resistance = range_of_("damping_resistance");
    const SettingRange capacitance = range_of_("damping_capacitance");
    search_rc(choose_values(resistance, 0, resistance.high, 20),
              choose_values(capacitance, 0, capacitance.high, 20));
    // Once more, closer, around the best.
    const double R = value_of(best_.settings, "damping_resistance");
    const double C = value_of(best_.settings, "damping_capacitance");
    search_rc(choose_values(resistance, R / 1.4, R * 1.4, 9),
              choose_values(capacitance, C / 1.4, C * 1.4, 9));
    return best_;
  }

  TuningChoice choose_cancellation() {
    const SettingRange range = range_of_("cancellation_resistance");
    const double winding = model_.device.drive.motor->warm_resistance();
    const double most = snap(target_.most_cancellation * winding, range, true);
    if (target_.cancellation) {
      const double wanted = std::min(*target_.cancellation, target_.most_cancellation) * winding;
      return try_settings({{"cancellation_resistance", snap(wanted, range, true)}});
    }
    // More of it allows a stiffer wall, up to where the loop with the winding's inductance takes
    // over: the first that is enough, else the stiffest.
    best_ = try_settings({{"cancellation_resistance", snap(0, range)}});
    for (int i = 1; i <= 40 && !best_.reaches_wall; ++i) {
      TuningChoice next =
          try_settings({{"cancellation_resistance", snap(most * i / 40, range, true)}});
      if (next.max_stiffness > best_.max_stiffness) best_ = std::move(next);
    }
    return best_;
  }

 private:
  TuningChoice try_settings(std::vector<Setting> settings) {
    throw_if_interrupted("choice of settings");
    TuningChoice choice{target_.circuit, std::move(settings), {}, 0, false};
    choice.device = make_tuned_device(model_.device, target_.circuit, choice.settings);
    for (const Operator& held_by : {Operator(FreeOperator{}), Operator(ClampedOperator{})})
      if (find_unstable_pole(build_device_network(choice.device, held_by))) return choice;
    StiffnessLimits limits(choice.device, model_.sampling, model_.controller, FreeOperator{},
                           GridDensity::coarse);
    const StiffnessLimit limit = limits.find_on_grid(wall_.damping);
    choice.max_stiffness = limit.feasible ? limit.stiffness : 0;
    choice.reaches_wall = limit.feasible && wall_.stiffness * target_.margin <= limit.stiffness;
    return choice;
  }

  bool is_better(const TuningChoice& a, const TuningChoice& b) const {
    if (a.reaches_wall != b.reaches_wall) return a.reaches_wall;
    if (a.reaches_wall) {
      const double mine = value_of(a.settings, "damping_capacitance");
      const double other = value_of(b.settings, "damping_capacitance");
      if (mine != other) return mine < other;
    }
    return a.max_stiffness > b.max_stiffness;
  }

  void search_rc(const std::vector<double>& resistances, const std::vector<double>& capacitances) {
    for (const double R : resistances) {
      for (const double C : capacitances) {
        TuningChoice next = try_settings({{"damping_resistance", R}, {"damping_capacitance", C}});
        if (best_.settings.empty() || is_better(next, best_)) best_ = std::move(next);
      }
    }
    if (best_.settings.empty())
      throw Error(ErrorCode::bad_input, "damping_resistance, damping_capacitance",
                  "the profile leaves no value above zero to choose from");
  }

  const PassivityModel& model_;
  const TuningTarget& target_;
  const RangeOf& range_of_;
  WallValues wall_;
  TuningChoice best_;
};

}  // namespace

double find_cancelled_resistance(const Drive& drive) {
  for (const Damping& damping : drive.damping)
    if (const auto* c = std::get_if<ResistanceCancellation>(&damping)) return c->resistance;
  return 0;
}

std::string_view name_of(TuningCircuit circuit) {
  return circuit == TuningCircuit::rc ? "rc" : "cancellation";
}

DriveMode mode_of(TuningCircuit circuit) {
  return circuit == TuningCircuit::rc ? DriveMode::current : DriveMode::voltage;
}

double value_of(const std::vector<Setting>& settings, std::string_view name) {
  for (const Setting& setting : settings)
    if (setting.name == name) return setting.value;
  throw Error(ErrorCode::bad_input, std::string(name), "is not among the settings");
}

double snap(double value, const SettingRange& range, bool down) {
  double snapped = value;
  if (range.step > 0) {
    const double steps = (value - range.low) / range.step;
    // A value on the lattice stays there, whatever its last digit.
    const double whole = down ? std::floor(steps + 1e-9) : std::round(steps);
    snapped = range.low + whole * range.step;
  }
  return std::clamp(snapped, range.low, range.high);
}

Device make_tuned_device(const Device& identified, TuningCircuit circuit,
                         const std::vector<Setting>& settings) {
  Device device = identified;
  const auto bandwidth = find_bandwidth(identified.drive.amplifier);
  device.drive.damping.clear();
  device.gain.reset();
  if (circuit == TuningCircuit::rc) {
    device.drive.amplifier = CurrentAmplifier{bandwidth};
    device.drive.damping.emplace_back(RcDamping{value_of(settings, "damping_resistance"),
                                                value_of(settings, "damping_capacitance")});
  } else {
    device.drive.amplifier = VoltageAmplifier{bandwidth};
    const double cancelled = value_of(settings, "cancellation_resistance");
    if (cancelled > 0) device.drive.damping.emplace_back(ResistanceCancellation{cancelled, {}});
    const Motor& motor = *device.drive.motor;
    const double left = motor.warm_resistance() - cancelled;
    if (left > 0) device.gain = left / motor.torque_constant;
  }
  return device;
}

TuningChoice choose_settings(const PassivityModel& model, const TuningTarget& target,
                             const RangeOf& range_of) {
  if (!model.device.drive.motor)
    throw Error(ErrorCode::bad_input, "motor", "missing: identify the motor first");
  Chooser chooser(model, target, range_of);
  return target.circuit == TuningCircuit::rc ? chooser.choose_rc() : chooser.choose_cancellation();
}

}  // namespace gyrator
