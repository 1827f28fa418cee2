#include "gyrator/twin/twin_bench.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr std::int64_t ticks_between_looks = 100;  // at the fault bits

void play(SimulatedAmplifier& amplifier, const Excitation& excitation) {
  amplifier.write("enable", 1);
  amplifier.start(excitation);
  while (amplifier.is_exciting() || amplifier.capture_state() == CaptureState::busy) {
    amplifier.feed_watchdog();
    amplifier.advance_ticks(ticks_between_looks);
    if (amplifier.faults() == 0) continue;
    throw Error(ErrorCode::device, "fault",
                fmt::format("{} during a {}: the amplifier has switched itself off",
                            describe_faults(amplifier.faults()), describe(excitation)));
  }
}

}  // namespace

BenchLimits TwinBench::limits() const {
  const TwinSettings& settings = amplifier_.settings();
  BenchLimits limits;
  limits.shortest_period = SimulatedAmplifier::tick;
  limits.most_samples = SimulatedAmplifier::most_samples;
  limits.largest_current = settings.current_limit;
  limits.largest_voltage = settings.voltage_limit;
  limits.largest_velocity = settings.velocity_limit;
  limits.position_quantum = amplifier_.device().position_quantum;
  limits.modes = {DriveMode::current, DriveMode::voltage};
  limits.kinds = {ExcitationKind::dc, ExcitationKind::step, ExcitationKind::sine,
                  ExcitationKind::chirp, ExcitationKind::prbs};
  return limits;
}

void TwinBench::check(const Excitation& excitation, const CaptureRequest& request) const {
  check_excitation(excitation);
  const BenchLimits known = limits();
  const bool by_current = excitation.mode == DriveMode::current;
  const double most = by_current ? known.largest_current : known.largest_voltage;
  if (find_peak(excitation) > most) {
    const std::string_view unit = unit_of(excitation.mode);
    throw Error(ErrorCode::bad_input, "excitation",
                fmt::format("{}: reaches {:g} {}, the {} is {:g} {}", describe(excitation),
                            find_peak(excitation), unit,
                            by_current ? "current_limit" : "voltage_limit", most, unit));
  }
  const double highest = std::max(excitation.frequency_hz, excitation.end_frequency_hz);
  if (highest > known.highest_frequency_hz || excitation.duration > known.longest_duration) {
    throw Error(ErrorCode::bad_input, "excitation",
                fmt::format("{}: must stay within {:g} Hz and {:g} s", describe(excitation),
                            known.highest_frequency_hz, known.longest_duration));
  }
  if (!std::isfinite(request.start) || !std::isfinite(request.period))
    throw Error(ErrorCode::bad_input, "capture", "a time that is not finite");
}

Capture TwinBench::run(const Excitation& excitation, const CaptureRequest& request) {
  check(excitation, request);
  amplifier_.write("enable", 0);
  amplifier_.write("drive_mode", excitation.mode == DriveMode::voltage ? 1 : 0);
  amplifier_.arm(request);
  try {
    play(amplifier_, excitation);
  } catch (...) {
    amplifier_.write("enable", 0);  // whatever happened
    throw;
  }
  amplifier_.write("enable", 0);
  return amplifier_.capture();
}

std::optional<double> TwinBench::winding_temperature() {
  return amplifier_.winding_temperature();
}

bool TwinBench::has_setting(std::string_view name) const {
  return SimulatedAmplifier::has_setting(name) || SimulatedAmplifier::has_actual(name) ||
         name == "clear_fault";
}

// As a digital potentiometer and a bank of switched capacitors would have them.
SettingRange TwinBench::setting_range(std::string_view name) const {
  if (name == "cancellation_resistance") return {0, 20, 0.01};
  if (name == "damping_resistance") return {0.1, 200, 0.1};
  if (name == "damping_capacitance") return {0, 10e-3, 10e-6};
  if (name == "damping_connected" || name == "enable" || name == "drive_mode") return {0, 1, 1};
  return {0, std::numeric_limits<double>::max(), 0};
}

}  // namespace gyrator
