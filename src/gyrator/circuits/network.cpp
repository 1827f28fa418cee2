#include "gyrator/circuits/network.hpp"

#include "gyrator/circuits/nonlinear_law.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <fmt/core.h>

namespace gyrator {
namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};

void check_positive(const std::string& element, const char* quantity, const char* unit,
                    double value) {
  if (std::isfinite(value) && value > 0) return;
  throw Error(ErrorCode::bad_input, element,
              fmt::format("{} of {:g} {}: must be positive and finite", quantity, value, unit));
}

void check_finite(const std::string& element, const char* quantity, double value) {
  if (std::isfinite(value)) return;
  throw Error(ErrorCode::bad_input, element,
              fmt::format("{} of {:g}: must be finite", quantity, value));
}

void check_values(const std::string& name, const Diode& e) {
  check_positive(name, "saturation current", "A", e.saturation_current);
  check_positive(name, "emission voltage", "V", e.emission_voltage);
}

void check_values(const std::string& name, const VoltageClamp& e) {
  check_positive(name, "voltage", "V", e.voltage);
  check_positive(name, "resistance", "ohm", e.resistance);
}

void check_values(const std::string& name, const SaturatingConductance& e) {
  check_positive(name, "conductance", "S", e.conductance);
  check_positive(name, "limit", "A", e.limit);
}

void check_values(const std::string& name, const CurrentLimiter& e) {
  check_positive(name, "current", "A", e.current);
  check_positive(name, "resistance", "ohm", e.resistance);
}

void check_values(const std::string& name, const LimitedVoltageControlledVoltageSource& e) {
  check_finite(name, "gain", e.gain);
  check_positive(name, "limit", "V", e.limit);
}

void check_values(const std::string& name, const LimitedVoltageControlledCurrentSource& e) {
  check_finite(name, "transconductance", e.transconductance);
  check_positive(name, "limit", "A", e.limit);
}

void check_values(const std::string& name, const ThermalResistor& e) {
  check_positive(name, "resistance", "ohm", e.resistance);
  check_finite(name, "temperature coefficient", e.temperature_coefficient);
  check_positive(name, "thermal resistance", "K/W", e.thermal_resistance);
  check_positive(name, "thermal capacity", "J/K", e.thermal_capacity);
  check_positive(name, "resistance at its initial temperature", "ohm",
                 e.resistance * (1 + e.temperature_coefficient * e.initial_rise));
}

}  // namespace

Network::Network() {
  nodes_.push_back({"ground", Domain::electrical});
}

NodeId Network::add_node(std::string name, Domain domain) {
  nodes_.push_back({std::move(name), domain});
  return {static_cast<int>(nodes_.size()) - 1};
}

int Network::add_input(std::string name) {
  inputs_.push_back(std::move(name));
  return static_cast<int>(inputs_.size()) - 1;
}

void Network::check_node(const std::string& element, NodeId node) const {
  if (node.index >= 0 && node.index < static_cast<int>(nodes_.size())) return;
  throw Error(ErrorCode::bad_input, element,
              fmt::format("node {} does not exist in the network", node.index));
}

// The nodes and elements that a law refers to beyond its own terminals.
template <class Law>
void Network::check_references(const std::string& name, const Law& law) const {
  if constexpr (requires { law.control_positive; }) {
    check_node(name, law.control_positive);
    check_node(name, law.control_negative);
  }
  if constexpr (requires { law.second_positive; }) {
    check_node(name, law.second_positive);
    check_node(name, law.second_negative);
  }
  if constexpr (requires { law.input; }) {
    const std::optional<int> input = law.input;
    if (input && (*input < 0 || *input >= static_cast<int>(inputs_.size()))) {
      throw Error(ErrorCode::bad_input, name,
                  fmt::format("input {} does not exist in the network", *input));
    }
  }
  if constexpr (requires { law.control; }) check_element(name, law.control);
  if constexpr (requires { law.first; }) {
    check_element(name, law.first);
    check_element(name, law.second);
  }
}

void Network::check_element(const std::string& name, ElementId id) const {
  if (id.index >= 0 && id.index < static_cast<int>(elements_.size())) return;
  throw Error(ErrorCode::bad_input, name,
              fmt::format("element {} does not exist in the network", id.index));
}

void Network::check_coupling(const std::string& name, const MutualInductance& coupling) const {
  const auto* first = std::get_if<Inductor>(&element(coupling.first).law);
  const auto* second = std::get_if<Inductor>(&element(coupling.second).law);
  if (!first || !second || coupling.first == coupling.second) {
    throw Error(ErrorCode::bad_input, name,
                fmt::format("couples {} and {}: two different inductors can be coupled",
                            element(coupling.first).name, element(coupling.second).name));
  }
  const double most = std::sqrt(first->inductance * second->inductance);
  if (std::abs(coupling.inductance) <= most * (1 + 1e-12)) return;
  throw Error(ErrorCode::bad_input, name,
              fmt::format("mutual inductance of {:g} H between {} and {}: at most {:g} H, the "
                          "geometric mean of the two",
                          coupling.inductance, element(coupling.first).name,
                          element(coupling.second).name, most));
}

ElementId Network::add(std::string name, NodeId positive, NodeId negative, ElementLaw law,
                       Role role) {
  check_node(name, positive);
  check_node(name, negative);
  if (find_element(name)) {
    throw Error(ErrorCode::bad_input, name,
                "an element of this name exists already: names are unique");
  }
  std::visit([&](const auto& e) { check_references(name, e); }, law);
  std::visit(
      Overloaded{
          [&](const Resistor& e) { check_positive(name, "resistance", "ohm", e.resistance); },
          [&](const Conductance& e) { check_positive(name, "conductance", "S", e.conductance); },
          [&](const Inductor& e) { check_positive(name, "inductance", "H", e.inductance); },
          [&](const Capacitor& e) { check_positive(name, "capacitance", "F", e.capacitance); },
          [&](const VoltageSource&) {},
          [&](const CurrentSource&) {},
          [&](const VoltageControlledVoltageSource& e) { check_finite(name, "gain", e.gain); },
          [&](const VoltageControlledCurrentSource& e) {
            check_finite(name, "transconductance", e.transconductance);
          },
          [&](const CurrentControlledVoltageSource& e) {
            check_finite(name, "transresistance", e.transresistance);
          },
          [&](const CurrentControlledCurrentSource& e) { check_finite(name, "gain", e.gain); },
          [&](const Transformer& e) { check_finite(name, "ratio", e.ratio); },
          [&](const Gyrator& e) { check_finite(name, "transconductance", e.transconductance); },
          [&](const MutualInductance& e) { check_coupling(name, e); },
          [&](const IdealOpAmp&) {},
          [&](const ConstantVoltageSource& e) { check_finite(name, "voltage", e.voltage); },
          [&](const ConstantCurrentSource& e) { check_finite(name, "current", e.current); },
          [&](const auto& nonlinear) { check_values(name, nonlinear); },
      },
      law);
  elements_.push_back({std::move(name), role, positive, negative, law});
  const ElementId id{static_cast<int>(elements_.size()) - 1};
  const bool constant = std::holds_alternative<ConstantVoltageSource>(law) ||
                        std::holds_alternative<ConstantCurrentSource>(law);
  if (!first_nonlinear_ && (constant || is_nonlinear(law))) first_nonlinear_ = id;
  return id;
}

std::optional<ElementId> Network::find_element(std::string_view name) const {
  const auto it = std::find_if(elements_.begin(), elements_.end(),
                               [&](const Element& e) { return e.name == name; });
  if (it == elements_.end()) return std::nullopt;
  return ElementId{static_cast<int>(it - elements_.begin())};
}

std::optional<NodeId> Network::find_node(std::string_view name) const {
  const auto it =
      std::find_if(nodes_.begin(), nodes_.end(), [&](const NodeInfo& n) { return n.name == name; });
  if (it == nodes_.end()) return std::nullopt;
  return NodeId{static_cast<int>(it - nodes_.begin())};
}

std::vector<std::string> Network::elements_at(NodeId node) const {
  std::vector<std::string> names;
  for (const auto& element : elements_) {
    bool touches = element.positive == node || element.negative == node;
    if (const auto* t = std::get_if<Transformer>(&element.law)) {
      touches = touches || t->second_positive == node || t->second_negative == node;
    }
    if (const auto* g = std::get_if<Gyrator>(&element.law)) {
      touches = touches || g->second_positive == node || g->second_negative == node;
    }
    if (touches) names.push_back(element.name);
  }
  return names;
}

}  // namespace gyrator
