#include "gyrator/circuits/spice_writer.hpp"

#include "gyrator/core/error.hpp"
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
            [](const auto&) { return 'x'; },  // refused by write_spice_netlist
        },
        law);
  }

  // A transformer's second port mirrors its current: it has an ammeter always.
  bool needs_ammeter(ElementId id) const {
    const ElementLaw& law = network_.element(id).law;
    if (std::holds_alternative<VoltageSource>(law)) return false;  // is one
    return sensed_[at(id)] || std::holds_alternative<Transformer>(law);
  }

  void name_devices(ElementId id) {
    const Element& element = network_.element(id);
    std::string& device = result_.devices[at(id)];
    device = make_name(letter_of(element.law), element.name);
    if (std::holds_alternative<VoltageSource>(element.law)) {
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
                          [](const auto&) { return std::string(); },
                      },
                      element.law);
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
            [](const auto&) {},  // refused by write_spice_netlist
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
  if (const auto nonlinear = network.find_nonlinear()) {
    throw Error(ErrorCode::bad_input, network.element(*nonlinear).name,
                "nonlinear elements and constant sources are not written as SPICE");
  }
  return Writer(network, options).write();
}

}  // namespace gyrator
