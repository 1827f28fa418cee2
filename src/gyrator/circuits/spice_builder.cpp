#include "gyrator/circuits/spice_builder.hpp"

#include "gyrator/circuits/spice_elements.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

// Far above any real circuit; without a limit ten short lines could ask for 2^30 elements.
constexpr std::size_t most_elements = 2000;
constexpr std::size_t most_nodes = 4000;
constexpr std::size_t most_instances = 2000;
constexpr int deepest_instance = 64;

[[noreturn]] void refuse(const std::string& place, std::string message) {
  throw Error(ErrorCode::bad_input, place, std::move(message));
}

void refuse_recursion(const SpiceCard& card, const SpiceInstance& instance) {
  std::vector<std::string> chain{instance.definition->name};
  int depth = 0;
  for (const SpiceInstance* at = instance.caller; at != nullptr; at = at->caller) {
    chain.push_back(at->definition->name);
    if (at->definition == instance.definition) {
      std::reverse(chain.begin(), chain.end());
      refuse(card.place, fmt::format("'{}': the subcircuit contains itself: {}", card.text,
                                     join(chain, " -> ")));
    }
    if (++depth > deepest_instance) {
      refuse(card.place, fmt::format("'{}': subcircuits contain subcircuits more than {} deep",
                                     card.text, deepest_instance));
    }
  }
}

}  // namespace

SpiceBuilder::SpiceBuilder(const SpiceDeck& deck, const SpiceReadOptions& options)
    : deck_(deck), options_(options) {}

SpiceCircuit SpiceBuilder::build(const SpiceDefinition& definition) {
  circuit_.name = definition.name;
  circuit_.place = definition.place;
  circuit_.nodes = {"0"};
  circuit_.pin_count = static_cast<int>(definition.pins.size());

  SpiceInstance top;
  top.definition = &deck_.top;
  for (const auto& parameter : deck_.top.parameters) top.scope.define(parameter);
  if (&definition == &deck_.top) {
    read_lines(top);
  } else {
    SpiceInstance instance;
    instance.definition = &definition;
    instance.around = &top;
    instance.caller = &top;
    instance.scope = SpiceScope(&top.scope);
    for (const std::string& pin : definition.pins) {
      instance.nodes[pin] = add_node(pin, definition.place);
    }
    for (const auto& parameter : definition.defaults) instance.scope.define(parameter);
    for (const auto& parameter : definition.parameters) instance.scope.define(parameter);
    read_lines(instance);
  }
  for (Control& control : std::exchange(controls_, {})) resolve(std::move(control));
  for (const Coupling& coupling : std::exchange(couplings_, {})) resolve(coupling);
  return std::move(circuit_);
}

void SpiceBuilder::read_lines(SpiceInstance& instance) {
  for (const SpiceCard& card : instance.definition->elements) {
    read_spice_element(card, instance, *this);
  }
}

NodeId SpiceBuilder::find_node(SpiceInstance& instance, std::string_view name) {
  std::string lower = lower_spice(name);
  if (lower == "0" || lower == "gnd") return ground;
  const auto found = instance.nodes.find(lower);
  if (found != instance.nodes.end()) return found->second;
  const NodeId node = add_node(instance.prefix + lower, instance.definition->place);
  instance.nodes[std::move(lower)] = node;
  return node;
}

NodeId SpiceBuilder::add_node(std::string name, const std::string& place) {
  if (circuit_.nodes.size() >= most_nodes) {
    refuse(place, fmt::format("the circuit has more than {} nodes", most_nodes));
  }
  circuit_.nodes.push_back(std::move(name));
  return {static_cast<int>(circuit_.nodes.size()) - 1};
}

void SpiceBuilder::add(SpiceElement element) {
  if (circuit_.elements.size() >= most_elements) {
    refuse(element.place, fmt::format("the circuit has more than {} elements", most_elements));
  }
  const auto [at, is_new] =
      index_.emplace(element.name, static_cast<int>(circuit_.elements.size()));
  if (!is_new) {
    refuse(element.place,
           fmt::format("the name {} is there a second time: first at {}", element.name,
                       circuit_.elements[static_cast<std::size_t>(at->second)].place));
  }
  circuit_.elements.push_back(std::move(element));
}

void SpiceBuilder::add_controlled(SpiceElement element, const std::string& prefix,
                                  std::string_view control) {
  controls_.push_back({std::move(element), prefix, lower_spice(control)});
}

void SpiceBuilder::add_coupling(const std::string& name, const std::string& place,
                                const std::string& prefix,
                                const std::vector<std::string>& inductors, double coupling) {
  couplings_.push_back({name, place, prefix, inductors, coupling});
}

SpiceInstance SpiceBuilder::find_definition(const SpiceCard& card, const std::string& name,
                                            SpiceInstance& caller) {
  SpiceInstance instance;
  instance.caller = &caller;
  std::vector<std::string> known;
  for (SpiceInstance* at = &caller; at != nullptr; at = at->around) {
    instance.definition = at->definition->find_definition(name);
    instance.around = at;
    if (instance.definition != nullptr) return instance;
    for (const auto& definition : at->definition->definitions) known.push_back(definition.name);
  }
  const SpiceDefinition& library = built_in_spice_library();
  instance.definition = library.find_definition(name);
  instance.around = nullptr;
  if (instance.definition != nullptr) return instance;
  for (const auto& definition : library.definitions) known.push_back(definition.name);
  refuse(card.place,
         fmt::format("'{}': {}{}", card.text, describe_unknown_name("subcircuit", name, known),
                     describe_missing_libraries()));
}

std::string SpiceBuilder::describe_missing_libraries() const {
  if (deck_.missing_libraries.empty()) return "";
  return "; these libraries were not found: " + join(deck_.missing_libraries);
}

SpiceModelUse SpiceBuilder::find_model(const SpiceCard& card, const std::string& name,
                                       SpiceInstance& instance) const {
  std::vector<std::string> known;
  for (SpiceInstance* at = &instance; at != nullptr; at = at->around) {
    if (const auto* model = at->definition->find_model(name)) return {model, at};
    for (const auto& model : at->definition->models) known.push_back(model.name);
  }
  refuse(card.place, fmt::format("'{}': {}{}", card.text,
                                 known.empty() ? fmt::format("there is no .model {}", name)
                                               : describe_unknown_name(".model", name, known),
                                 describe_missing_libraries()));
}

void SpiceBuilder::add_instance(const SpiceCard& card, SpiceInstance& caller) {
  if (card.words.size() < 2) {
    refuse(card.place, fmt::format("'{}': the name of a subcircuit is missing", card.text));
  }
  SpiceInstance instance = find_definition(card, card.words.back(), caller);
  const SpiceDefinition& definition = *instance.definition;
  refuse_recursion(card, instance);
  const std::size_t given = card.words.size() - 2;
  if (given != definition.pins.size()) {
    refuse(card.place,
           fmt::format("'{}': gives {} nodes: the subcircuit {} has {} ({})", card.text, given,
                       definition.name, definition.pins.size(), join(definition.pins)));
  }
  if (++instances_ > most_instances) {
    refuse(card.place, fmt::format("the circuit has more than {} subcircuits", most_instances));
  }
  instance.prefix = caller.prefix + lower_spice(card.words[0]) + ".";
  for (std::size_t i = 0; i < given; ++i) {
    instance.nodes[definition.pins[i]] = find_node(caller, card.words[i + 1]);
  }
  instance.scope = SpiceScope(instance.around != nullptr ? &instance.around->scope : nullptr);
  override_parameters(card, caller, instance);
  read_lines(instance);
  if (const auto useless = instance.scope.find_useless_override()) {
    std::vector<std::string> known;
    for (const auto& parameter : definition.defaults) known.push_back(parameter.name);
    refuse(card.place,
           fmt::format("'{}': {}", card.text,
                       known.empty()
                           ? fmt::format("unknown parameter '{}': the subcircuit {} has none",
                                         *useless, definition.name)
                           : describe_unknown_name("parameter", *useless, known)));
  }
}

void SpiceBuilder::override_parameters(const SpiceCard& card, SpiceInstance& caller,
                                       SpiceInstance& instance) {
  for (const auto& parameter : instance.definition->defaults) instance.scope.define(parameter);
  for (const auto& parameter : instance.definition->parameters) {
    const auto set = std::find_if(card.assignments.begin(), card.assignments.end(),
                                  [&](const auto& a) { return a.name == parameter.name; });
    if (set != card.assignments.end()) {
      refuse(card.place,
             fmt::format("'{}': parameter {} is fixed by a .param line at {}: only those "
                         "of the .subckt line can be set",
                         card.text, parameter.name, parameter.place));
    }
    instance.scope.define(parameter);
  }
  for (const auto& [name, value] : card.assignments) {
    instance.scope.override_value(name, caller.scope.evaluate(value, card.place), card.place);
  }
}

// The element that another one refers to by name, as seen from the other's instance.
template <class... Laws>
int SpiceBuilder::find_reference(const std::string& place, const std::string& prefix,
                                 const std::string& name, std::string_view letter,
                                 std::string_view what) const {
  const auto found = index_.find(prefix + name);
  const auto fits = [&](const SpiceElement& element, std::string_view local) {
    return local.starts_with(letter) && (std::holds_alternative<Laws>(element.law) || ...);
  };
  if (found != index_.end()) {
    if (fits(circuit_.elements[static_cast<std::size_t>(found->second)], name))
      return found->second;
  }
  std::vector<std::string> known;
  for (const SpiceElement& element : circuit_.elements) {
    if (!element.name.starts_with(prefix)) continue;
    std::string local = element.name.substr(prefix.size());
    if (fits(element, local)) known.push_back(std::move(local));
  }
  if (known.empty()) refuse(place, fmt::format("there is no {} '{}', and no other", what, name));
  refuse(place, describe_unknown_name(what, name, known));
}

void SpiceBuilder::resolve(Control control) {
  const ElementId source{find_reference<VoltageSource, ConstantVoltageSource>(
      control.element.place, control.prefix, control.source, "v", "voltage source")};
  if (auto* f = std::get_if<CurrentControlledCurrentSource>(&control.element.law)) {
    f->control = source;
  } else if (auto* h = std::get_if<CurrentControlledVoltageSource>(&control.element.law)) {
    h->control = source;
  }
  add(std::move(control.element));
}

void SpiceBuilder::resolve(const Coupling& coupling) {
  std::vector<int> coils;
  for (const std::string& name : coupling.inductors) {
    const int coil = find_reference<Inductor>(coupling.place, coupling.prefix, lower_spice(name),
                                              "l", "inductor (above 0 H)");
    if (std::find(coils.begin(), coils.end(), coil) != coils.end()) {
      refuse(coupling.place, fmt::format("{} names {} twice", coupling.name, name));
    }
    coils.push_back(coil);
  }
  const auto inductance = [&](int coil) {
    return std::get<Inductor>(circuit_.elements[static_cast<std::size_t>(coil)].law).inductance;
  };
  for (std::size_t i = 0; i < coils.size(); ++i) {
    for (std::size_t j = i + 1; j < coils.size(); ++j) {
      const double mutual =
          coupling.coefficient * std::sqrt(inductance(coils[i]) * inductance(coils[j]));
      const bool single = coils.size() == 2;
      add({single ? coupling.name : fmt::format("{}.{}.{}", coupling.name, i + 1, j + 1),
           Role::device, ground, ground,
           MutualInductance{mutual, ElementId{coils[i]}, ElementId{coils[j]}}, coupling.place});
    }
  }
}

}  // namespace gyrator
