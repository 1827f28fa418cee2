#include "gyrator/circuits/spice_scope.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>

#include <fmt/core.h>

namespace gyrator {
namespace {

// Parameters that refer to parameters that refer …: a limit for the stack's sake.
constexpr std::size_t deepest_reference = 200;

}  // namespace

void SpiceScope::define(const SpiceParameter& parameter) {
  Entry& entry = entries_[parameter.name];
  const SpiceParameter& first = entry.parameter;
  if (entry.defined && first.place == parameter.place && first.text == parameter.text) {
    return;  // the same file, included twice
  }
  if (entry.defined) {
    throw Error(ErrorCode::bad_input, parameter.place,
                fmt::format("parameter {} is defined a second time: first at {}", parameter.name,
                            first.place));
  }
  entry.defined = true;
  entry.parameter = parameter;
}

void SpiceScope::override_value(const std::string& name, double value, const std::string& place) {
  Entry& entry = entries_[name];
  if (entry.overridden) {
    throw Error(ErrorCode::bad_input, place, fmt::format("parameter {} is given twice", name));
  }
  entry.overridden = true;
  entry.value = value;
}

double SpiceScope::evaluate(std::string_view text, const std::string& place) {
  std::vector<std::string> path;
  return evaluate(text, place, path);
}

double SpiceScope::evaluate(std::string_view text, const std::string& place,
                            std::vector<std::string>& path) {
  return evaluate_spice_expression(
      text, place, [&](const std::string& name) { return find_value(name, place, path); });
}

double SpiceScope::find_value(const std::string& name, const std::string& place,
                              std::vector<std::string>& path) {
  for (SpiceScope* scope = this; scope != nullptr; scope = scope->outer_) {
    const auto found = scope->entries_.find(name);
    if (found == scope->entries_.end()) continue;
    Entry& entry = found->second;
    entry.used = true;
    if (entry.value) return *entry.value;
    path.push_back(name);
    if (entry.busy) {
      const auto first = std::find(path.begin(), path.end(), name);
      throw Error(ErrorCode::bad_input, entry.parameter.place,
                  fmt::format("parameter {} depends on itself: {}", name,
                              join({first, path.end()}, " -> ")));
    }
    if (path.size() > deepest_reference) {
      throw Error(ErrorCode::bad_input, entry.parameter.place,
                  fmt::format("parameter {} is reached through more than {} others", name,
                              deepest_reference));
    }
    entry.busy = true;
    entry.value = scope->evaluate(entry.parameter.text, entry.parameter.place, path);
    entry.busy = false;
    path.pop_back();
    return *entry.value;
  }
  throw Error(ErrorCode::bad_input, place,
              fmt::format("parameter '{}' is not defined{}", name, suggest_name(name, names())));
}

std::optional<std::string> SpiceScope::find_useless_override() const {
  for (const auto& [name, entry] : entries_) {
    if (entry.overridden && !entry.defined && !entry.used) return name;
  }
  return std::nullopt;
}

std::vector<std::string> SpiceScope::names() const {
  std::vector<std::string> all;
  for (const SpiceScope* scope = this; scope != nullptr; scope = scope->outer_) {
    for (const auto& [name, entry] : scope->entries_) all.push_back(name);
  }
  return all;
}

}  // namespace gyrator
