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

/// Whose energy an element handles in the ledger: the device's own, the operator's, nobody's (a
/// signal inside an amplifier, which carries no physical power), the amplifier's supply (what its
/// limits take back counts as not delivered), or a contact's effort, which whoever computes it
/// books.
enum class Role { device, operator_side, signal, supply, contact };

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

/// v = V, always. Acts from t = 0 on, with the circuit in its steady state at t = 0.
struct ConstantVoltageSource {
  double voltage = 0;
};
/// i = I, always; as ConstantVoltageSource.
struct ConstantCurrentSource {
  double current = 0;
};

// Nonlinear laws (nonlinear_law.hpp evaluates them). Each is known by its argument y and has value
// 0 at y = 0; linear tools take its slope at the operating point.

/// i = I_s (exp(v / V_e) - 1), V_e = n k T / q (Shockley 1949). Continued linearly above
/// v = 50 V_e, where e^50 I_s is far beyond any real current, so that no iterate overflows.
struct Diode {
  double saturation_current = 1e-14;   ///< I_s [A]
  double emission_voltage = 0.025852;  ///< V_e [V]; n = 1 at 300 K
};
/// i = 0 for |v| <= V, (v -+ V) / r beyond: a bidirectional suppressor, or a supply's rails.
struct VoltageClamp {
  double voltage = 0;     ///< V [V]
  double resistance = 0;  ///< r [ohm]
};
/// i = G v, at most +-I. In the mechanical domain a friction brake that imitates a damper, f = b v
/// up to its holding effort (equations, section 3; An and Kwon 2006).
struct SaturatingConductance {
  double conductance = 0;  ///< G [S, N.s/m, N.m.s/rad]
  double limit = 0;        ///< I [A, N, N.m]
};
/// v = 0 for |i| <= I, r (i -+ I) beyond: in series, it keeps a source's current near its limit.
struct CurrentLimiter {
  double current = 0;     ///< I [A]
  double resistance = 0;  ///< r [ohm]
};
/// v = gain * v_control, at most +-limit.
struct LimitedVoltageControlledVoltageSource {
  double gain = 0;
  double limit = 0;  ///< [V]
  NodeId control_positive, control_negative;
};
/// i = transconductance * v_control, at most +-limit.
struct LimitedVoltageControlledCurrentSource {
  double transconductance = 0;
  double limit = 0;  ///< [A]
  NodeId control_positive, control_negative;
};
/// v = R(h) i, R(h) = R_0 (1 + a h), warmed by its own heat:
///   C_th dh/dt = R(h) i^2 - h / R_th                                         (thermal-1)
/// h rise above the temperature at which it has R_0, which is also the ambient's. Steady at
/// constant i for a R_0 i^2 R_th < 1, beyond it runs away.
struct ThermalResistor {
  double resistance = 0;               ///< R_0 [ohm]
  double temperature_coefficient = 0;  ///< a [1/K]
  double thermal_resistance = 0;       ///< R_th [K/W]
  double thermal_capacity = 0;         ///< C_th [J/K]
  double initial_rise = 0;             ///< h at t = 0 and for the linear tools [K]
};

using ElementLaw =
    std::variant<Resistor, Conductance, Inductor, Capacitor, VoltageSource, CurrentSource,
                 VoltageControlledVoltageSource, VoltageControlledCurrentSource,
                 CurrentControlledVoltageSource, CurrentControlledCurrentSource, Transformer,
                 Gyrator, MutualInductance, IdealOpAmp, ConstantVoltageSource,
                 ConstantCurrentSource, Diode, VoltageClamp, SaturatingConductance, CurrentLimiter,
                 LimitedVoltageControlledVoltageSource, LimitedVoltageControlledCurrentSource,
                 ThermalResistor>;

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

/// A network of electrical and mechanical elements, by name.
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

  /// Neither nonlinear laws nor constant sources.
  bool is_linear() const { return !first_nonlinear_; }
  /// The first element that makes it nonlinear or biases it; none in a linear network.
  std::optional<ElementId> find_nonlinear() const { return first_nonlinear_; }

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
  std::optional<ElementId> first_nonlinear_;
};

}  // namespace gyrator
