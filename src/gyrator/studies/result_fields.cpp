#include "gyrator/studies/result_fields.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/plots/pretty_text.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

namespace gyrator {
namespace {

using nlohmann::json;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

[[noreturn]] void fail(const std::string& place, const std::string& key, const std::string& rule) {
  throw Error(ErrorCode::bad_input, place + ": /" + key, rule);
}

}  // namespace

std::string command_of(const json& result) {
  if (!result.is_object())
    throw Error(ErrorCode::bad_input, "result", "is no JSON object; a command's --json output is");
  auto command = optional_text(result, "command");
  if (command.empty()) fail("result", "command", "is missing; every result names its command");
  return command;
}

const json& required(const json& object, const std::string& key, const std::string& place) {
  if (!object.is_object()) throw Error(ErrorCode::bad_input, place, "is no JSON object");
  const auto at = object.find(key);
  if (at == object.end()) fail(place, key, "is missing");
  return *at;
}

const json& required_array(const json& object, const std::string& key, const std::string& place) {
  const auto& array = required(object, key, place);
  if (!array.is_array()) fail(place, key, "must be an array");
  return array;
}

double required_number(const json& object, const std::string& key, const std::string& place) {
  const auto& value = required(object, key, place);
  if (value.is_null()) return none;
  if (!value.is_number()) fail(place, key, "must be a number");
  return value.get<double>();
}

std::vector<double> required_numbers(const json& object, const std::string& key,
                                     const std::string& place) {
  const auto& array = required(object, key, place);
  if (!array.is_array()) fail(place, key, "must be an array of numbers");
  std::vector<double> numbers;
  numbers.reserve(array.size());
  for (const auto& value : array) {
    if (!value.is_number() && !value.is_null()) fail(place, key, "must be an array of numbers");
    numbers.push_back(value.is_null() ? none : value.get<double>());
  }
  return numbers;
}

double optional_number(const json& object, const std::string& key) {
  if (!object.is_object()) return none;
  const auto at = object.find(key);
  return at != object.end() && at->is_number() ? at->get<double>() : none;
}

bool optional_flag(const json& object, const std::string& key, bool otherwise) {
  if (!object.is_object()) return otherwise;
  const auto at = object.find(key);
  return at != object.end() && at->is_boolean() ? at->get<bool>() : otherwise;
}

std::string optional_text(const json& object, const std::string& key) {
  if (!object.is_object()) return {};
  const auto at = object.find(key);
  return at != object.end() && at->is_string() ? at->get<std::string>() : std::string();
}

bool has(const json& object, const std::string& key) {
  return object.is_object() && object.contains(key) && !object.at(key).is_null() &&
         !object.at(key).empty();
}

std::string unit_of(const json& result, const std::string& quantity) {
  const json units = result.is_object() ? result.value("units", json::object()) : json::object();
  auto named = optional_text(units, quantity);
  if (!named.empty()) return named;
  const bool linear = optional_text(units, "position") == "m";
  if (quantity == "inertia") return linear ? "kg" : "kg.m^2";
  if (quantity == "position") return linear ? "m" : "rad";
  if (quantity == "velocity") return linear ? "m/s" : "rad/s";
  if (quantity == "effort") return linear ? "N" : "N.m";
  if (quantity == "damping") return linear ? "N.s/m" : "N.m.s/rad";
  if (quantity == "stiffness") return linear ? "N/m" : "N.m/rad";
  if (quantity == "response") return linear ? "m/N" : "rad/(N.m)";
  if (quantity == "energy") return "J";
  if (quantity == "current") return "A";
  return {};
}

std::string figure_title(const json& result, const std::string& subject) {
  const auto name = optional_text(result, "model_name");
  return name.empty() ? subject : subject + ": " + name;
}

json find_criterion(const json& passivity, const std::string& name) {
  const auto criteria = passivity.find("criteria");
  if (criteria == passivity.end() || !criteria->is_array()) return nullptr;
  for (const auto& criterion : *criteria)
    if (optional_text(criterion, "name") == name) return criterion;
  return nullptr;
}

std::string criterion_title(const std::string& name) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 6> titles = {{
      {"spring_damper", "spring–damper rule, b > KT/2 + |B|"},
      {"frequency_dependent", "textbook, Re Z + bᵥ > 0"},
      {"exact_disk", "true limit, exact aliased disk"},
      {"quantized_coulomb", "encoder steps and dry friction"},
      {"coupled", "stable with the model's operator"},
      {"time", "co-simulated hits settle"},
  }};
  for (const auto& [known, title] : titles)
    if (name == known) return std::string(title);
  return name;
}

std::string operator_in_words(const json& passivity) {
  const auto& example = required(passivity, "counterexample", "passivity result");
  const double inertia = optional_number(example, "inertia");
  const double stiffness = optional_number(example, "stiffness");
  const std::size_t resonators = has(example, "resonators") && example["resonators"].is_array()
                                     ? example["resonators"].size()
                                     : 0;
  const bool heavy = inertia > 0;  // false for NaN
  const bool elastic = stiffness > 0;
  const bool linear = unit_of(passivity, "position") == "m";
  const std::string body = linear ? "mass" : "inertia";
  const auto body_text = body + " of " + pretty_quantity(inertia, unit_of(passivity, "inertia"), 3);
  const auto spring_text =
      "a spring of " + pretty_quantity(stiffness, unit_of(passivity, "stiffness"), 3);

  std::string words;
  if (heavy && elastic) {
    words = (linear ? "a " : "an ") + body_text + " held by " + spring_text;
  } else if (heavy) {
    words = "a plain " + body_text + " held in the hand";
  } else if (elastic) {
    words = spring_text + " held against the handle";
  } else {
    words = resonators > 0 ? "a lossless operator" : "the handle let go, nothing attached";
  }
  if (resonators == 1) words += ", with one resonator hung on it";
  if (resonators > 1) words += ", with " + std::to_string(resonators) + " resonators hung on it";
  return words;
}

Finding finding_of(const json& passivity) {
  const json textbook = find_criterion(passivity, "frequency_dependent");
  const json exact = find_criterion(passivity, "exact_disk");
  Finding finding{false, false, none, none};
  const auto judged = [](const json& criterion) {
    return criterion.is_object() && criterion.contains("holds") && criterion["holds"].is_boolean();
  };
  if (!judged(textbook) || !judged(exact)) return finding;
  // Behind a wave line the textbook speaks of another controller than the disk.
  if (optional_text(passivity, "sampled_signal") == "wave_integral") return finding;
  finding.textbook_holds = optional_flag(textbook, "holds", false);
  finding.exact_holds = optional_flag(exact, "holds", false);
  finding.textbook_limit = optional_number(textbook, "max_stiffness");
  finding.true_limit = optional_number(exact, "max_stiffness");
  return finding;
}

}  // namespace gyrator
