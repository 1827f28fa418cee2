#include "gyrator/circuits/spice_element_line.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>

#include <fmt/core.h>

namespace gyrator {

SpiceElementLine::SpiceElementLine(const SpiceCard& card, SpiceInstance& instance,
                                   SpiceBuilder& builder)
    : card_(card),
      instance_(instance),
      builder_(builder),
      name_(instance.prefix + lower_spice(card.words.front())) {
  for (std::size_t i = 0; i < card.assignments.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (card.assignments[i].name == card.assignments[j].name) {
        refuse(fmt::format("{} is given twice", card.assignments[i].name));
      }
    }
  }
}

void SpiceElementLine::refuse(const std::string& reason) const {
  throw Error(ErrorCode::bad_input, card_.place, fmt::format("'{}': {}", card_.text, reason));
}

std::string SpiceElementLine::peek() const {
  return has_word() ? lower_spice(card_.words[next_]) : std::string{};
}

const std::string& SpiceElementLine::take_word(std::string_view what) {
  if (!has_word()) refuse(fmt::format("{} is missing", what));
  return card_.words[next_++];
}

NodeId SpiceElementLine::take_node(std::string_view what) {
  return builder_.find_node(instance_, take_word(what));
}

double SpiceElementLine::take_number(std::string_view what) {
  const std::string& word = take_word(what);
  if (word[0] == '{' || word[0] == '\'') return instance_.scope.evaluate(word, card_.place);
  const auto number = find_spice_number(word);
  if (number && number->length == word.size()) return number->value;
  const auto names = instance_.scope.names();
  const bool parameter = std::find(names.begin(), names.end(), lower_spice(word)) != names.end();
  refuse(fmt::format("{} of '{}': a number such as 4.7k or an expression in braces{}", what, word,
                     parameter ? fmt::format("; did you mean {{{}}}?", word) : ""));
}

std::optional<double> SpiceElementLine::take_value(std::string_view name) {
  known_.emplace_back(name);
  for (const auto& assignment : card_.assignments) {
    if (assignment.name != name) continue;
    taken_.emplace_back(name);
    return instance_.scope.evaluate(assignment.value, card_.place);
  }
  return std::nullopt;
}

std::optional<double> SpiceElementLine::take_part(std::string_view name, bool positive) {
  const auto value = take_value(name);
  if (value && (*value < 0 || (positive && *value == 0))) {
    refuse(fmt::format("{} = {:g}: must {}", name, *value,
                       positive ? "be positive" : "not be negative"));
  }
  return value;
}

void SpiceElementLine::ignore(std::initializer_list<std::string_view> names) {
  taken_.insert(taken_.end(), names.begin(), names.end());
}

void SpiceElementLine::finish() {
  if (has_word()) refuse(fmt::format("unexpected '{}'", card_.words[next_]));
  for (const auto& assignment : card_.assignments) {
    if (std::find(taken_.begin(), taken_.end(), assignment.name) != taken_.end()) continue;
    refuse(describe_unknown_name("parameter", assignment.name, known_));
  }
}

// Nodes of the instance's own: neither ground nor a pin.
bool SpiceElementLine::is_inner(NodeId node) const {
  if (node == ground) return false;
  const auto& pins = instance_.definition->pins;
  return std::none_of(pins.begin(), pins.end(),
                      [&](const std::string& pin) { return instance_.nodes.at(pin) == node; });
}

SpiceElement SpiceElementLine::make_element(std::string_view suffix, NodeId positive,
                                            NodeId negative, const ElementLaw& law) const {
  const bool signal = instance_.definition->built_in && (is_inner(positive) || is_inner(negative));
  return {name_ + std::string(suffix),
          signal ? Role::signal : Role::device,
          positive,
          negative,
          law,
          card_.place};
}

void SpiceElementLine::add(std::string_view suffix, NodeId positive, NodeId negative,
                           const ElementLaw& law) {
  builder_.add(make_element(suffix, positive, negative, law));
}

NodeId SpiceElementLine::add_inner_node(std::string_view suffix) {
  return builder_.add_node(name_ + std::string(suffix), card_.place);
}

}  // namespace gyrator
