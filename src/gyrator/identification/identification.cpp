#include "gyrator/identification/identification.hpp"

#include "gyrator/amplifiers/settings_guard.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/identification/experiments.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr double widest_share = 0.5;  // half the interval per value, of what counts as identified

IdentifiedParameter make_parameter(const std::string& name, const std::string& unit,
                                   const Estimate& estimate, double confidence) {
  IdentifiedParameter parameter{name, unit, estimate.value, {}, {}, false, {}};
  const Interval interval = find_interval(estimate, confidence);
  parameter.low = interval.low;
  parameter.high = interval.high;
  const double half = (interval.high - interval.low) / 2;
  parameter.identifiable = estimate.value > 0 && half < widest_share * estimate.value;
  return parameter;
}

IdentifiedParameter make_unknown(const std::string& name, const std::string& unit,
                                 const std::string& note) {
  return {name, unit, {}, {}, {}, false, note};
}

void explain(IdentifiedParameter& parameter, const std::string& note) {
  if (!parameter.identifiable) parameter.note = note;
}

// Parameters

void add_amplifier(Identification& found, double confidence) {
  if (!found.amplifier) {
    const std::string note =
        "the amplifier does not capture its command, from which the current lags";
    found.parameters.push_back(make_unknown("bandwidth", "Hz", note));
    found.parameters.push_back(make_unknown("delay", "s", note));
    return;
  }
  const Estimate constant = found.amplifier->fit.at(1);
  const Interval interval = find_interval(constant, confidence);
  const auto to_hz = [](double seconds) { return 1 / (2 * std::numbers::pi * seconds); };
  IdentifiedParameter bandwidth{"bandwidth", "Hz", to_hz(constant.value), to_hz(interval.high), {},
                                false,       {}};
  if (interval.low > 0) {
    bandwidth.high = to_hz(interval.low);
    bandwidth.identifiable = (interval.high - interval.low) / 2 < widest_share * constant.value;
  }
  explain(bandwidth, "too high to be told from a delay at the frequencies that can be played");
  found.parameters.push_back(bandwidth);
  IdentifiedParameter delay = make_parameter("delay", "s", found.amplifier->fit.at(2), confidence);
  // None at all is an answer too.
  delay.identifiable = *delay.high - *delay.low < found.tick;
  explain(delay, "cannot be told from the amplifier's bandwidth to better than a tick");
  found.parameters.push_back(delay);
}

// What the lag's own errors make of the inductance, by its slope.
double find_lag_error(const Identification& found, const WindingOptions& options) {
  if (!found.amplifier) return 0;
  double sum = 0;
  for (const int unknown : {1, 2}) {
    WindingOptions moved = options;
    const double deviation = found.amplifier->fit.at(unknown).deviation;
    double& place = unknown == 1 ? moved.lag->time_constant : moved.lag->delay;
    const double step = std::min(deviation, 0.01 * found.tick);
    if (!(step > 0)) continue;
    place += step;
    const auto fit = fit_winding(found.sines, found.windows, moved);
    const double change = fit->fit.values[1] - found.winding->fit.values[1];
    sum += std::pow(change * deviation / step, 2);
  }
  return std::sqrt(sum);
}

void add_winding(Identification& found, const IdentificationOptions& options,
                 const WindingOptions& winding) {
  if (!found.winding) {
    const std::string note = "the amplifier does not capture the terminal voltage";
    found.parameters.push_back(make_unknown("resistance", "ohm", note));
    found.parameters.push_back(make_unknown("inductance", "H", note));
    found.parameters.push_back(make_unknown("torque_constant", "N.m/A", note));
    return;
  }
  Estimate resistance = found.winding->fit.at(0);
  const double warm = 1 + options.temperature_coefficient * (found.winding_temperature - 298.15);
  Estimate measured = resistance;
  measured.value *= warm;
  measured.deviation *= warm;
  if (found.temperature_known)
    resistance = add_error(resistance, resistance.value * options.temperature_coefficient *
                                           options.temperature_error / std::sqrt(3.0));
  found.parameters.push_back(make_parameter("resistance", "ohm", resistance, options.confidence));
  found.parameters.back().note =
      found.temperature_known ? "at 298.15 K" : "as measured: the winding's temperature is unknown";
  found.parameters.push_back(
      make_parameter("resistance_as_measured", "ohm", measured, options.confidence));
  if (found.temperature_known)
    found.parameters.back().note = fmt::format("at {:.1f} K", found.winding_temperature);
  const Estimate inductance = add_error(found.winding->fit.at(1), find_lag_error(found, winding));
  found.parameters.push_back(make_parameter("inductance", "H", inductance, options.confidence));
  explain(found.parameters.back(),
          "w L is too small against R at the frequencies that the amplifier reaches");
  found.parameters.push_back(
      make_parameter("torque_constant", "N.m/A", found.winding->fit.at(2), options.confidence));
  explain(found.parameters.back(), "the motor moves too little for its back-EMF to be seen");
}

void add_motion(Identification& found, double confidence) {
  const std::array<std::pair<const char*, const char*>, 3> names{
      {{"inertia", "kg.m^2"}, {"damping", "N.m.s/rad"}, {"coulomb_friction", "N.m"}}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto& [name, unit] = names[i];
    if (!found.motion) {
      found.parameters.push_back(
          make_unknown(name, unit, "the motor does not move, or no sensor sees it"));
    } else if (!found.winding) {
      found.parameters.push_back(make_unknown(
          name, unit, "only its ratio to the torque constant, which needs the voltage"));
    } else {
      const Estimate constant = found.winding->fit.at(2);
      found.parameters.push_back(make_parameter(
          name, unit, multiply(found.motion->fit.at(static_cast<int>(i)), constant), confidence));
      explain(found.parameters.back(), "below the noise of the measured current");
    }
  }
}

}  // namespace

const IdentifiedParameter& Identification::find(const std::string& name) const {
  for (const IdentifiedParameter& parameter : parameters)
    if (parameter.name == name) return parameter;
  throw Error(ErrorCode::bad_input, "identification", "no parameter named " + name);
}

bool is_slow(const MotionWindow& window, const Identification& found) {
  const auto slowest = std::min_element(
      found.windows.begin(), found.windows.end(),
      [](const auto& a, const auto& b) { return a.frequency_hz < b.frequency_hz; });
  return window.frequency_hz <= slowest->frequency_hz;
}

Identification identify(Bench& bench, const IdentificationOptions& options,
                        const ExperimentListener& listener) {
  plan_identification(bench.limits(), options);  // refuses what cannot be
  Identification found;
  found.tick = bench.limits().shortest_period;
  found.position_quantum = bench.limits().position_quantum;
  SettingsGuard quiet(bench);
  Experiments experiments(bench, options, listener, found);
  experiments.find_amplitude();
  experiments.sweep_sines();
  found.amplifier = fit_amplifier(found.sines, found.tick);
  const auto apparent =
      found.amplifier ? found.amplifier : fit_apparent_amplifier(found.sines, found.tick);
  if (apparent) found.lag = apparent->lag(found.tick);
  if (experiments.find_motion()) {
    experiments.measure_inertia();
    experiments.measure_friction();
  }
  quiet.put_back();

  WindingOptions winding;
  winding.lag = found.lag;
  winding.motion = found.motion;
  winding.position_quantum = found.position_quantum;
  winding.temperature_coefficient = options.temperature_coefficient;
  found.winding = fit_winding(found.sines, found.windows, winding);
  found.winding_options = winding;
  double sum = 0;
  for (const SineMeasurement& sine : found.sines) sum += sine.temperature;
  found.winding_temperature = sum / static_cast<double>(found.sines.size());
  add_winding(found, options, winding);
  add_motion(found, options.confidence);
  add_amplifier(found, options.confidence);
  return found;
}

}  // namespace gyrator
