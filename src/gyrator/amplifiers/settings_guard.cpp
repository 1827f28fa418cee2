#include "gyrator/amplifiers/settings_guard.hpp"

#include <algorithm>
#include <array>
#include <exception>

namespace gyrator {

std::vector<std::string> find_disturbing_settings(const Bench& bench) {
  constexpr std::array disturbing{"cancellation_resistance", "damping_connected",
                                  "back_emf_damping"};
  std::vector<std::string> names;
  for (const char* name : disturbing)
    if (bench.has_setting(name)) names.emplace_back(name);
  return names;
}

SettingsGuard::SettingsGuard(Bench& bench, const std::vector<std::string>& values) : bench_(bench) {
  const std::vector<std::string> disturbing = find_disturbing_settings(bench);
  for (const std::string& name : values) {
    const bool is_switch =
        std::find(disturbing.begin(), disturbing.end(), name) != disturbing.end();
    if (!is_switch && bench.has_setting(name)) values_.push_back({name, bench.read_setting(name)});
  }
  std::vector<Setting> found;
  for (const std::string& name : disturbing) found.push_back({name, bench.read_setting(name)});
  try {
    for (const Setting& each : found) {
      switches_.push_back(each);  // first: a write may act although its answer is lost
      if (each.value != 0) bench.write_setting(each.name, 0);
    }
  } catch (...) {
    close_again_quietly();
    throw;
  }
}

// No value has been written by now, and what could not be switched off is on still.
void SettingsGuard::close_again_quietly() noexcept {
  try {
    for (auto each = switches_.rbegin(); each != switches_.rend(); ++each)
      if (bench_.read_setting(each->name) != each->value)
        bench_.write_setting(each->name, each->value);
  } catch (const std::exception&) {
    // As in put_back_quietly().
  }
}

void SettingsGuard::put_back() {
  for (const Setting& each : switches_)
    if (bench_.read_setting(each.name) != 0) bench_.write_setting(each.name, 0);
  for (const Setting& each : values_) bench_.write_setting(each.name, each.value);
  for (auto each = switches_.rbegin(); each != switches_.rend(); ++each)
    if (each->value != 0) bench_.write_setting(each->name, each->value);
  is_over_ = true;
}

void SettingsGuard::put_back_quietly() noexcept {
  if (is_over_) return;
  try {
    put_back();
  } catch (const std::exception&) {
    // The link is gone: the session behind the bench says so, and its journal has the values.
  }
}

}  // namespace gyrator
