// What makes a simulated amplifier switch itself off.

#include "gyrator/core/error.hpp"
#include "gyrator/twin/simulated_amplifier.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace gyrator {
namespace {

constexpr double trip_ratio = 1.25;          // above a limit
constexpr std::int64_t slow_every = 10;      // ticks between looks at voltage and energy
constexpr double growth = 4;                 // of the stored energy at a zero command
constexpr double floor_part = 0.05;          // of the current limit, whose energy is noise
constexpr std::int64_t settling_ticks = 50;  // in which amplifier and branches may still deliver

constexpr std::array<std::string_view, twin_fault_count> fault_names{
    "overcurrent", "overvoltage", "overtemperature", "overspeed", "instability", "watchdog"};

}  // namespace

std::string_view name_of(TwinFault fault) {
  return fault_names.at(static_cast<std::size_t>(fault));
}

std::string describe_faults(unsigned bits) {
  std::string text;
  for (std::size_t bit = 0; bit < fault_names.size(); ++bit) {
    if ((bits >> bit & 1U) == 0) continue;
    if (!text.empty()) text += ", ";
    text += fault_names.at(bit);
  }
  return text.empty() ? "none" : text;
}

void SimulatedAmplifier::clear_faults() {
  faults_ = 0;
}

void SimulatedAmplifier::trip(TwinFault fault) {
  faults_ |= 1U << static_cast<unsigned>(fault);
  stop();
  TwinSettings off = settings_;
  off.enable = false;
  apply(off);
}

void SimulatedAmplifier::protect() {
  if (!(std::abs(current_) <= trip_ratio * settings_.current_limit)) {
    trip(TwinFault::overcurrent);
  } else if (!(std::abs(plant_->now().velocity()) <= settings_.velocity_limit)) {
    trip(TwinFault::overspeed);
  } else if (winding_temperature() > settings_.temperature_limit) {
    trip(TwinFault::overtemperature);
  } else if (settings_.watchdog_period > 0 && static_cast<double>(watched_ticks_ - fed_) >
                                                  settings_.watchdog_period * ticks_per_second) {
    trip(TwinFault::watchdog);
  } else if (now_ % slow_every == 0) {
    const double output = plant_->now().voltage();
    if (std::abs(output) > trip_ratio * settings_.voltage_limit) {
      trip(TwinFault::overvoltage);
    } else {
      watch_energy();
    }
  }
}

// With a zero command all that a stable amplifier and its motor hold only falls.
void SimulatedAmplifier::watch_energy() {
  const auto on_the_way = static_cast<std::int64_t>(on_the_way_.size());
  const double energy = plant_->now().stored_energy();
  if (now_ < quiet_since_ + on_the_way + settling_ticks) {
    least_energy_ = energy;
    return;
  }
  least_energy_ = std::min(least_energy_, energy);
  const Motor& motor = *twin_.device.drive.motor;
  const double current = floor_part * settings_.current_limit;
  const double floor = std::max(motor.inductance / 2 * current * current, 1e-9);
  if (energy > std::max(growth * least_energy_, floor)) trip(TwinFault::instability);
}

}  // namespace gyrator
