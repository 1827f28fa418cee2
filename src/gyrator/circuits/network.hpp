#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace gyrator {

/// A node of the network; node 0 is the reference (electrical ground and the inertial frame).
struct NodeId {
  int index = 0;
  friend bool operator==(NodeId, NodeId) = default;
};
inline constexpr NodeId ground{0};

/// Position of an element in Network::elements().
struct ElementId {
  int index = 0;
  friend bool operator==(ElementId, ElementId) = default;
};

enum class Domain { electrical, mechanical };

/// Whose energy an element handles in the ledger: the device's own, the operator's, or
/// nobody's (a signal inside an amplifier, which carries no physical power).
enum class Role { device, operator_side, signal };

// The closed list of element laws. v is the across quantity from the positive to the negative
// node (voltage [V] or velocity [m/s, rad/s]); i the through quantity flowing from the positive
// node through the element (current [A] or effort [N, N.m]); power into the element is v i.
// In the mobility analogy a damper b is a Conductance, a mass m a Capacitor and a spring k an
// Inductor of 1/k, so that one network holds both domains.

struct Resistor {
  double resistance = 0;
};  ///< v = R i
struct Conductance {
  double conductance = 0;
};  ///< i = G v
struct Inductor {
  double inductance = 0;
};  ///< v = L di/dt
struct Capacitor {
  double capacitance = 0;
};  ///< i = C dv/dt
/// v = input, or v = 0 without one (an ammeter).
struct VoltageSource {
  std::optional<int> input;
};
struct CurrentSource {
  int input = 0;
};  ///< i = input
/// v = gain * v_control
struct VoltageControlledVoltageSource {
  double gain = 0;
  NodeId control_positive, control_negative;
};
/// i = transconductance * v_control
struct VoltageControlledCurrentSource {
  double transconductance = 0;
  NodeId control_positive, control_negative;
};
/// v = transresistance * i_control; the control must carry a branch current (source, inductor …)
struct CurrentControlledVoltageSource {
  double transresistance = 0;
  ElementId control;
};
/// i = gain * i_control
struct CurrentControlledCurrentSource {
  double gain = 0;
  ElementId control;
};
/// Ideal, lossless: v = ratio * v_2, i_2 = -ratio * i.
struct Transformer {
  double ratio = 1;
  NodeId second_positive, second_negative;
};
/// Ideal, lossless: i = transconductance * v_2, i_2 = -transconductance * v.
struct Gyrator {
  double transconductance = 1;
  NodeId second_positive, second_negative;
};

/// Magnetic coupling of two inductors, M = k sqrt(L_1 L_2): L_1 di_1/dt + M di_2/dt = v_1 and
/// likewise in the second. Has no terminals of its own (both at ground).
struct MutualInductance {
  double inductance = 0;  ///< M [H], |M| <= sqrt(L_1 L_2), of either sign
  ElementId first, second;
};
/// Ideal operational amplifier (a nullor): whatever flows from its output keeps both inputs equal.
/// The output lies between the element's own terminals; the inputs draw nothing.
struct IdealOpAmp {
  NodeId control_positive, control_negative;
};

using ElementLaw =
    std::variant<Resistor, Conductance, Inductor, Capacitor, VoltageSource, CurrentSource,
                 VoltageControlledVoltageSource, VoltageControlledCurrentSource,
                 CurrentControlledVoltageSource, CurrentControlledCurrentSource, Transformer,
                 Gyrator, MutualInductance, IdealOpAmp>;

struct Element {
  std::string name;
  Role role = Role::device;
  NodeId positive, negative;
  ElementLaw law;
};

struct NodeInfo {
  std::string name;
  Domain domain = Domain::electrical;
};

/// A linear network of electrical and mechanical elements, by name.
///
/// Built once, then only read. Values are checked as they come in: a resistance, inductance,
/// capacitance or conductance must be finite and positive (Error bad_input naming the element).
class Network {
 public:
  Network();

  NodeId add_node(std::string name, Domain domain);
  int add_input(std::string name);
  ElementId add(std::string name, NodeId positive, NodeId negative, ElementLaw law,
                Role role = Role::device);

  const std::vector<NodeInfo>& nodes() const { return nodes_; }
  const std::vector<Element>& elements() const { return elements_; }
  const std::vector<std::string>& inputs() const { return inputs_; }
  const Element& element(ElementId id) const {
    return elements_[static_cast<std::size_t>(id.index)];
  }

  std::optional<ElementId> find_element(std::string_view name) const;
  std::optional<NodeId> find_node(std::string_view name) const;

  /// Names of the elements that touch a node, for error messages.
  std::vector<std::string> elements_at(NodeId node) const;

 private:
  void check_node(const std::string& element, NodeId node) const;
  void check_element(const std::string& name, ElementId id) const;
  void check_coupling(const std::string& name, const MutualInductance& coupling) const;
  template <class Law>
  void check_references(const std::string& name, const Law& law) const;

  std::vector<NodeInfo> nodes_;
  std::vector<Element> elements_;
  std::vector<std::string> inputs_;
};

}  // namespace gyrator
