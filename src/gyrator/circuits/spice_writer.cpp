#include "gyrator/circuits/spice_writer.hpp"

#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/core.h>

namespace gyrator {
namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};

// k T/q at 27 degC with ngspice 39's constants (CODATA 2014) [V].
constexpr double ngspice_thermal_voltage = 1.38064852e-23 * 300.15 / 1.6021766208e-19;

// Comments stand on one line: whatever would end it becomes a blank.
std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return text;
}

// Legal SPICE names, unique regardless of case. They begin with a letter that is no keyword by
// itself and an underscore or the device's letter, so that none is "0", "gnd" or "time".
class Names {
 public:
  std::string make(std::string_view start, std::string_view original) {
    std::string name(start);
    for (const char c : original) {
      const bool upper = c >= 'A' && c <= 'Z';
      const bool kept = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || upper;
      name += upper ? static_cast<char>(c - 'A' + 'a') : kept ? c : '_';
    }
    std::string unique = name;
    for (int i = 2; !taken_.insert(unique).second; ++i) unique = fmt::format("{}__{}", name, i);
    return unique;
  }

 private:
  std::set<std::string> taken_;
};

class Writer {
 public:
  Writer(const Network& network, const SpiceOptions& options)
      : network_(network), options_(options) {
    const auto& elements = network.elements();
    result_.ammeters.resize(elements.size());
    result_.devices.resize(elements.size());
    sensed_.resize(elements.size());
    for (const auto& element : elements) {
      if (const auto* h = std::get_if<CurrentControlledVoltageSource>(&element.law)) {
        sensed_[at(h->control)] = true;
      } else if (const auto* f = std::get_if<CurrentControlledCurrentSource>(&element.law)) {
        sensed_[at(f->control)] = true;
      }
    }
  }

  SpiceNetlist write() {
    write_nodes();
    // A control's ammeter must have its name before the element that it controls is written.
    const int count = static_cast<int>(network_.elements().size());
    for (int i = 0; i < count; ++i) name_devices({i});
    for (int i = 0; i < count; ++i) write_element({i});
    for (const NodeId id : options_.held_at_rest) {
      hold(network_.nodes()[static_cast<std::size_t>(id.index)].name, node(id));
    }
    return std::move(result_);
  }

 private:
  static std::size_t at(ElementId id) { return static_cast<std::size_t>(id.index); }
  const std::string& node(NodeId id) const {
    return result_.nodes[static_cast<std::size_t>(id.index)];
  }
  std::string make_name(char letter, std::string_view original) {
    return names_.make(fmt::format("{}{}_", letter, options_.prefix), original);
  }

  void write_nodes() {
    const auto& nodes = network_.nodes();
    result_.nodes.emplace_back("0");
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      result_.nodes.push_back(names_.make("n" + options_.prefix + "_", nodes[i].name));
      const bool moves = nodes[i].domain == Domain::mechanical;
      result_.lines += fmt::format("* {}: {} [{}]\n", result_.nodes.back(), one_line(nodes[i].name),
                                   moves ? options_.mechanical.velocity : "V");
    }
  }

  static char letter_of(const ElementLaw& law) {
    return std::visit(
        Overloaded{
            [](const Resistor&) { return 'r'; }, [](const Conductance&) { return 'r'; },
            [](const Inductor&) { return 'l'; }, [](const Capacitor&) { return 'c'; },
            [](const VoltageSource&) { return 'v'; }, [](const CurrentSource&) { return 'i'; },
            [](const VoltageControlledVoltageSource&) { return 'e'; },
            [](const VoltageControlledCurrentSource&) { return 'g'; },
            [](const CurrentControlledVoltageSource&) { return 'h'; },
            [](const CurrentControlledCurrentSource&) { return 'f'; },
            [](const Transformer&) { return 'e'; }, [](const Gyrator&) { return 'g'; },
            [](const MutualInductance&) { return 'k'; }, [](const IdealOpAmp&) { return 'e'; },
            [](const ConstantVoltageSource&) { return 'v'; },
            [](const ConstantCurrentSource&) { return 'i'; }, [](const Diode&) { return 'd'; },
            [](const auto&) { return 'b'; },  // of a formula
        },
        law);
  }

  static bool is_ammeter(const ElementLaw& law) {
    return std::holds_alternative<VoltageSource>(law) ||
           std::holds_alternative<ConstantVoltageSource>(law);
  }

  // A transformer's second port mirrors its current, and some laws are functions of theirs.
  bool needs_ammeter(ElementId id) const {
    const ElementLaw& law = network_.element(id).law;
    if (is_ammeter(law)) return false;
    return sensed_[at(id)] || std::holds_alternative<Transformer>(law) ||
           std::holds_alternative<CurrentLimiter>(law) ||
           std::holds_alternative<ThermalResistor>(law);
  }

  void name_devices(ElementId id) {
    const Element& element = network_.element(id);
    std::string& device = result_.devices[at(id)];
    device = make_name(letter_of(element.law), element.name);
    if (is_ammeter(element.law)) {
      result_.ammeters[at(id)] = device;
    } else if (needs_ammeter(id)) {
      result_.ammeters[at(id)] = make_name('v', element.name + ".ammeter");
    }
  }

  template <class... Words>
  void line(const std::string& comment, const std::string& device, const Words&... words) {
    result_.lines += device;
    ((result_.lines += ' ', result_.lines += words), ...);
    if (!comment.empty()) result_.lines += " ; " + comment;
    result_.lines += '\n';
  }

  std::string input(int index) const {
    const auto i = static_cast<std::size_t>(index);
    return i < options_.inputs.size() ? options_.inputs[i] : "DC 0";
  }

  std::string initial(ElementId id) const {
    if (at(id) >= options_.initial.size()) return "";
    return "ic=" + format_number(options_.initial[at(id)]);
  }

  // "motor.resistance [ohm]"; "mechanics.damping, a damper of 0.0001 N.m.s/rad".
  std::string describe(const Element& element) const {
    const NodeId place = element.positive == ground ? element.negative : element.positive;
    const bool moves =
        network_.nodes()[static_cast<std::size_t>(place.index)].domain == Domain::mechanical;
    const SpiceMechanicalUnits& units = options_.mechanical;
    const auto tell = [&](const char* electrical, const char* part, double value,
                          const std::string& unit) {
      return moves ? fmt::format(", {} of {:.6g} {}", part, value, unit)
                   : fmt::format(" [{}]", electrical);
    };
    return one_line(element.name) +
           std::visit(Overloaded{
                          [&](const Resistor& e) {
                            return tell("ohm", "a damper", 1 / e.resistance, units.damping);
                          },
                          [&](const Conductance& e) {
                            return tell("ohm = 1/S", "a damper", e.conductance, units.damping);
                          },
                          [&](const Inductor& e) {
                            return tell("H", "a spring", 1 / e.inductance, units.stiffness);
                          },
                          [&](const Capacitor& e) {
                            return tell("F", "an inertia", e.capacitance, units.inertia);
                          },
                          [](const Transformer&) { return std::string(", a transformer"); },
                          [](const Gyrator&) { return std::string(", a gyrator [S]"); },
                          [](const IdealOpAmp&) { return std::string(", an ideal op-amp"); },
                          [](const VoltageClamp&) { return std::string(", a clamp"); },
                          [&](const SaturatingConductance&) {
                            return std::string(moves ? ", a friction brake" : ", saturating");
                          },
                          [](const CurrentLimiter&) { return std::string(", a current limiter"); },
                          [](const ThermalResistor&) {
                            return std::string(", a resistance that warms [ohm]");
                          },
                          [](const auto&) { return std::string(); },
                      },
                      element.law);
  }

  // The voltage of a node over another, in a formula.
  std::string across(NodeId positive, NodeId negative) const {
    if (positive == negative) return "0";
    if (negative == ground) return fmt::format("v({})", node(positive));
    if (positive == ground) return fmt::format("(-v({}))", node(negative));
    return fmt::format("v({},{})", node(positive), node(negative));
  }
  static std::string dead_zone(const std::string& y, double edge, double slope) {
    return fmt::format("{2}*(max({0}-{1},0)+min({0}+{1},0))", y, format_number(edge),
                       format_number(slope));
  }
  static std::string saturate(const std::string& y, double slope, double limit) {
    return fmt::format("max(-{2},min({2},{1}*{0}))", y, format_number(slope), format_number(limit));
  }

  void hold(const std::string& name, const std::string& held) {
    const std::string inner = names_.make("n" + options_.prefix + "_", name + ".hold");
    const std::string inductor = make_name('l', name + ".hold");
    line("holds " + one_line(name) + " at an operating point", inductor, held, inner, "1e15 ic=0");
    const std::string resistor = make_name('r', name + ".hold");
    line("", resistor, inner, "0", "1e-9");
    // Of 1e15 H, a step of 1e-11 s would leave nothing of the other numbers in the equations.
    result_.release += fmt::format("alter {} = 1e20\nalter {} = 1\n", resistor, inductor);
  }

  // C_th dh/dt = R(h) i^2 - h/R_th for the rise over the initial one, so that it starts from zero.
  void write_thermal(ElementId id, const ThermalResistor& e, const std::string& p,
                     const std::string& n, const std::string& comment) {
    const std::string& name = network_.element(id).name;
    const std::string warm = names_.make("n" + options_.prefix + "_", name + ".warming");
    const std::string i = fmt::format("i({})", result_.ammeters[at(id)]);
    const std::string rise = fmt::format("({}+v({}))", format_number(e.initial_rise), warm);
    const std::string resistance = fmt::format("{}*(1+{}*{})", format_number(e.resistance),
                                               format_number(e.temperature_coefficient), rise);
    line(comment, result_.devices[at(id)], p, n, fmt::format("v={}*{}", resistance, i));
    line("its heat, less what flows off [W]", make_name('b', name + ".heat"), "0", warm,
         fmt::format("i={}*{}*{}-{}/{}", resistance, i, i, rise,
                     format_number(e.thermal_resistance)));
    line("its rise beyond the initial one [K]", make_name('c', name + ".warming"), warm, "0",
         format_number(e.thermal_capacity), "ic=0");
    hold(name + ".warming", warm);
  }

  void write_element(ElementId id) {
    const Element& element = network_.element(id);
    const std::string& device = result_.devices[at(id)];
    const std::string& n = node(element.negative);
    const std::string comment = describe(element);
    std::string p = node(element.positive);
    if (needs_ammeter(id)) {
      const std::string inner = names_.make("n" + options_.prefix + "_", element.name + ".inner");
      line("current into " + one_line(element.name), result_.ammeters[at(id)], p, inner, "DC 0");
      p = inner;
    }
    const auto number = format_number;
    std::visit(
        Overloaded{
            [&](const Resistor& e) { line(comment, device, p, n, number(e.resistance)); },
            [&](const Conductance& e) { line(comment, device, p, n, number(1 / e.conductance)); },
            [&](const Inductor& e) {
              line(comment, device, p, n, number(e.inductance), initial(id));
            },
            [&](const Capacitor& e) {
              line(comment, device, p, n, number(e.capacitance), initial(id));
            },
            // A long list of points would hide what follows it: comment first.
            [&](const VoltageSource& e) {
              result_.lines += "* " + comment + "\n";
              line("", device, p, n, e.input ? input(*e.input) : "DC 0");
            },
            [&](const CurrentSource& e) {
              result_.lines += "* " + comment + "\n";
              line("", device, p, n, input(e.input));
            },
            [&](const VoltageControlledVoltageSource& e) {
              line(comment, device, p, n, node(e.control_positive), node(e.control_negative),
                   number(e.gain));
            },
            [&](const VoltageControlledCurrentSource& e) {
              line(comment, device, p, n, node(e.control_positive), node(e.control_negative),
                   number(e.transconductance));
            },
            [&](const CurrentControlledVoltageSource& e) {
              line(comment, device, p, n, result_.ammeters[at(e.control)],
                   number(e.transresistance));
            },
            [&](const CurrentControlledCurrentSource& e) {
              line(comment, device, p, n, result_.ammeters[at(e.control)], number(e.gain));
            },
            [&](const Transformer& e) {
              const std::string& p2 = node(e.second_positive);
              const std::string& n2 = node(e.second_negative);
              line(comment, device, p, n, p2, n2, number(e.ratio));
              line("its second port", make_name('f', element.name), p2, n2,
                   result_.ammeters[at(id)], number(-e.ratio));
            },
            [&](const Gyrator& e) {
              const std::string& p2 = node(e.second_positive);
              const std::string& n2 = node(e.second_negative);
              line(comment, device, p, n, p2, n2, number(e.transconductance));
              line("its second port", make_name('g', element.name + ".second"), p2, n2, p, n,
                   number(-e.transconductance));
            },
            [&](const MutualInductance& e) {
              const double first = std::get<Inductor>(network_.element(e.first).law).inductance;
              const double second = std::get<Inductor>(network_.element(e.second).law).inductance;
              // M = sqrt(L_1 L_2) may round to a hair above one, which SPICE refuses.
              const double k = std::clamp(e.inductance / std::sqrt(first * second), -1.0, 1.0);
              line(comment, device, result_.devices[at(e.first)], result_.devices[at(e.second)],
                   number(k));
            },
            [&](const IdealOpAmp& e) {
              const std::string drive =
                  names_.make("n" + options_.prefix + "_", element.name + ".drive");
              line(comment, device, p, n, drive, "0", "1");
              line("holds its inputs equal", make_name('g', element.name), "0", drive,
                   node(e.control_positive), node(e.control_negative), "1");
            },
            [&](const ConstantVoltageSource& e) {
              line(comment, device, p, n, "DC", number(e.voltage));
            },
            [&](const ConstantCurrentSource& e) {
              line(comment, device, p, n, "DC", number(e.current));
            },
            [&](const Diode& e) {
              const std::string model = make_name('m', element.name);
              line(comment, device, p, n, model);
              line("", ".model", model,
                   fmt::format("d(is={} n={})", number(e.saturation_current),
                               number(e.emission_voltage / ngspice_thermal_voltage)));
            },
            [&](const ThermalResistor& e) { write_thermal(id, e, p, n, comment); },
            [&](const auto&) { line(comment, device, p, n, formula(id, p)); },
        },
        element.law);
  }

  // Piecewise linear laws. `p` is the node behind the element's ammeter, where it has one.
  std::string formula(ElementId id, const std::string& p) const {
    const Element& element = network_.element(id);
    const std::string v = fmt::format("v({},{})", p, node(element.negative));
    return std::visit(
        Overloaded{
            [&](const VoltageClamp& e) { return "i=" + dead_zone(v, e.voltage, 1 / e.resistance); },
            [&](const SaturatingConductance& e) {
              return "i=" + saturate(v, e.conductance, e.limit);
            },
            [&](const CurrentLimiter& e) {
              const std::string i = fmt::format("i({})", result_.ammeters[at(id)]);
              return "v=" + dead_zone(i, e.current, e.resistance);
            },
            [&](const LimitedVoltageControlledVoltageSource& e) {
              return "v=" +
                     saturate(across(e.control_positive, e.control_negative), e.gain, e.limit);
            },
            [&](const LimitedVoltageControlledCurrentSource& e) {
              return "i=" + saturate(across(e.control_positive, e.control_negative),
                                     e.transconductance, e.limit);
            },
            [](const auto&) { return std::string(); },  // has a device of its own
        },
        element.law);
  }

  const Network& network_;
  const SpiceOptions& options_;
  SpiceNetlist result_;
  std::vector<bool> sensed_;
  Names names_;
};

}  // namespace

SpiceNetlist write_spice_netlist(const Network& network, const SpiceOptions& options) {
  return Writer(network, options).write();
}

}  // namespace gyrator
