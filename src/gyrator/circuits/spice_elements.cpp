#include "gyrator/circuits/spice_elements.hpp"

#include "gyrator/circuits/spice_diode.hpp"
#include "gyrator/circuits/spice_element_line.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Line = SpiceElementLine;

constexpr auto ratings = {"tol", "pwr", "v", "irms", "ipk", "mfg", "type", "pn"};

// What a two-terminal component has beside its value.
void ignore_ratings(Line& line) {
  for (const char* rating : ratings) line.ignore({rating});
  for (const auto& assignment : line.card().assignments) {
    const std::string& name = assignment.name;
    if (name == "temp" || name == "dtemp" || name.starts_with("tc")) {
      line.refuse(fmt::format("{}: values that depend on temperature are not read", name));
    }
  }
  const auto initial = line.take_value("ic");
  if (initial && *initial != 0) {
    line.refuse(
        fmt::format("ic = {:g}: circuits start at rest; initial values are not read", *initial));
  }
}

double take_multiplicity(Line& line) {
  return line.take_part("m", true).value_or(1);
}

// The value behind the nodes, or assigned to the element's own letter: "R1 a b R=1k".
double take_main_value(Line& line, std::string_view letter, std::string_view what) {
  const auto assigned = line.take_value(letter);
  return assigned ? *assigned : line.take_number(what);
}

[[noreturn]] void refuse_negative(const Line& line, std::string_view what, double value,
                                  std::string_view unit, std::string_view rule) {
  line.refuse(fmt::format("{} of {} is {:g} {}: {}", what, line.name(), value, unit, rule));
}

void add_resistance(Line& line, std::string_view suffix, NodeId positive, NodeId negative,
                    double resistance) {
  if (resistance > 0) {
    line.add(suffix, positive, negative, Resistor{resistance});
  } else if (resistance == 0) {
    line.add(suffix, positive, negative, VoltageSource{});
  } else if (line.builder().options().allow_negative) {
    line.add(suffix, positive, negative,
             VoltageControlledCurrentSource{1 / resistance, positive, negative});
  } else {
    refuse_negative(line, "resistance", resistance, "ohm",
                    "a negative component value supplies energy and has to be allowed explicitly "
                    "(\"allow_negative\": true)");
  }
}

void add_inductance(Line& line, std::string_view suffix, NodeId positive, NodeId negative,
                    double inductance) {
  if (inductance < 0) {
    refuse_negative(line, "inductance", inductance, "H", "a negative component value: must not be");
  }
  if (inductance == 0) {
    line.add(suffix, positive, negative, VoltageSource{});
  } else {
    line.add(suffix, positive, negative, Inductor{inductance});
  }
}

void add_capacitance(Line& line, std::string_view suffix, NodeId positive, NodeId negative,
                     double capacitance) {
  if (capacitance < 0) {
    refuse_negative(line, "capacitance", capacitance, "F",
                    "a negative component value: must not be");
  }
  if (capacitance > 0) line.add(suffix, positive, negative, Capacitor{capacitance});
}

// LTspice's losses across a whole component; m components are in parallel.
void add_parallel_parts(Line& line, NodeId positive, NodeId negative, double m) {
  if (const auto r = line.take_part("rpar", true)) {
    line.add(".rpar", positive, negative, Resistor{*r / m});
  }
  if (const auto c = line.take_part("cpar")) {
    add_capacitance(line, ".cpar", positive, negative, *c * m);
  }
}

// LTspice's resistance in series: the node behind it, or the given one without.
NodeId add_series_resistance(Line& line, NodeId from, double m) {
  const double r = line.take_part("rser").value_or(0);
  if (r == 0) return from;
  const NodeId behind = line.add_inner_node(".rser");
  line.add(".rser", from, behind, Resistor{r / m});
  return behind;
}

void read_resistor(Line& line) {
  const NodeId positive = line.take_node("the first node");
  const NodeId negative = line.take_node("the second node");
  const double value = take_main_value(line, "r", "resistance");
  const double m = take_multiplicity(line);
  ignore_ratings(line);
  if (line.peek() == "noiseless") line.take_word("");
  line.finish();
  add_resistance(line, "", positive, negative, value / m);
}

// n+ - Rser - Lser (RLshunt across it) - C - n-, and Rpar, Cpar across all of it.
void read_capacitor(Line& line) {
  const NodeId positive = line.take_node("the first node");
  const NodeId negative = line.take_node("the second node");
  const double value = take_main_value(line, "c", "capacitance");
  const double m = take_multiplicity(line);
  ignore_ratings(line);
  const double lser = line.take_part("lser").value_or(0);
  const auto shunt = line.take_part("rlshunt", true);
  if (value == 0) {
    line.take_part("rser");
  } else {
    NodeId inner = add_series_resistance(line, positive, m);
    if (lser > 0) {
      const NodeId behind = line.add_inner_node(".lser");
      line.add(".lser", inner, behind, Inductor{lser / m});
      if (shunt) line.add(".rlshunt", inner, behind, Resistor{*shunt / m});
      inner = behind;
    }
    add_capacitance(line, "", inner, negative, value * m);
  }
  add_parallel_parts(line, positive, negative, m);
  line.finish();
}

// n+ - Rser - L - n-, and Rpar, Cpar across both.
void read_inductor(Line& line) {
  const NodeId positive = line.take_node("the first node");
  const NodeId negative = line.take_node("the second node");
  const double value = take_main_value(line, "l", "inductance");
  const double m = take_multiplicity(line);
  ignore_ratings(line);
  add_inductance(line, "", add_series_resistance(line, positive, m), negative, value / m);
  add_parallel_parts(line, positive, negative, m);
  line.finish();
}

void read_coupling(Line& line) {
  std::vector<std::string> inductors{line.take_word("the first inductor"),
                                     line.take_word("the second inductor")};
  const auto is_inductor = [&] { return line.peek().starts_with("l"); };
  while (is_inductor()) inductors.push_back(line.take_word(""));
  const auto assigned = line.take_value("k");
  const double k = assigned ? *assigned : line.take_number("the coupling");
  line.finish();
  if (std::abs(k) > 1) line.refuse(fmt::format("a coupling of {:g}: must be from -1 to 1", k));
  line.builder().add_coupling(line.name(), line.card().place, line.instance().prefix, inductors, k);
}

// Of zero they are an ammeter and an open circuit, and leave the network linear.
void add_constant_source(Line& line, NodeId positive, NodeId negative, double value,
                         bool is_voltage) {
  if (is_voltage && value == 0) {
    line.add("", positive, negative, VoltageSource{});
  } else if (is_voltage) {
    line.add("", positive, negative, ConstantVoltageSource{value});
  } else if (value != 0) {
    line.add("", positive, negative, ConstantCurrentSource{value});
  }
}

// [DC] value and AC amplitude phase, in any order; the AC part says nothing about the circuit.
double take_source_value(Line& line) {
  constexpr std::array waveforms{"pulse", "sin",      "sine",    "exp",      "pwl",     "sffm",
                                 "am",    "wavefile", "trnoise", "trrandom", "external"};
  double value = line.take_value("dc").value_or(0);
  line.ignore({"ac"});
  const auto is_number = [&] {
    const std::string word = line.peek();
    return !word.empty() && (word[0] == '{' || word[0] == '\'' || find_spice_number(word));
  };
  while (line.has_word()) {
    const std::string word = line.peek();
    const std::string function = word.substr(0, word.find('('));
    if (std::find(waveforms.begin(), waveforms.end(), function) != waveforms.end()) {
      line.refuse(fmt::format("the waveform {}: sources that vary in time are not read", function));
    }
    if (word == "ac") {
      line.take_word("");
      for (int i = 0; i < 2 && is_number(); ++i) line.take_number("the AC part");
    } else {
      if (word == "dc") line.take_word("");
      value = line.take_number("the source's value");
    }
  }
  return value;
}

void read_voltage_source(Line& line) {
  const NodeId positive = line.take_node("the positive node");
  const NodeId negative = line.take_node("the negative node");
  const double value = take_source_value(line);
  const NodeId inner = add_series_resistance(line, positive, 1);
  if (const auto c = line.take_part("cpar")) add_capacitance(line, ".cpar", positive, negative, *c);
  line.finish();
  add_constant_source(line, inner, negative, value, true);
}

void read_current_source(Line& line) {
  const NodeId positive = line.take_node("the positive node");
  const NodeId negative = line.take_node("the negative node");
  const double value = take_source_value(line) * take_multiplicity(line);
  line.finish();
  add_constant_source(line, positive, negative, value, false);
}

// Takes "POLY(1)" where it stands; other polynomials and formulas are not linear.
bool take_polynomial(Line& line) {
  constexpr std::array formulas{"value", "laplace", "table", "freq", "vol", "cur", "poly"};
  const auto refuse_formula = [&](const std::string& word) {
    const std::string name = word.substr(0, word.find('('));
    if (std::find(formulas.begin(), formulas.end(), name) == formulas.end()) return;
    line.refuse(fmt::format("{}: a behavioural source; linear ones with a gain are read", name));
  };
  for (const auto& assignment : line.card().assignments) refuse_formula(assignment.name);
  const std::string word = line.peek();
  if (word == "poly(1)") {
    line.take_word("");
    return true;
  }
  refuse_formula(word);
  return false;
}

// The gain, or a polynomial's coefficients p0 p1 …, all but p1 zero; a single one is p1.
double take_gain(Line& line, bool polynomial) {
  std::vector<double> coefficients{line.take_number("the gain")};
  while (polynomial && line.has_word()) {
    coefficients.push_back(line.take_number("a coefficient"));
  }
  if (coefficients.size() == 1) return coefficients[0];
  for (std::size_t power = 0; power < coefficients.size(); ++power) {
    if (power != 1 && coefficients[power] != 0) {
      line.refuse("a polynomial that is not linear: all coefficients but the second must be 0");
    }
  }
  return coefficients[1];
}

// An op-amp's limit (built-in library).
constexpr double unlimited = 1e300;
double take_limit(Line& line) {
  if (!line.instance().definition->built_in) return unlimited;
  return line.take_part("limit", true).value_or(unlimited);
}

void read_voltage_controlled(Line& line, bool is_voltage) {
  const NodeId positive = line.take_node("the positive node");
  const NodeId negative = line.take_node("the negative node");
  const bool polynomial = take_polynomial(line);
  const NodeId control_positive = line.take_node("the positive control node");
  const NodeId control_negative = line.take_node("the negative control node");
  const double gain = take_gain(line, polynomial);
  if (is_voltage) {
    const double limit = take_limit(line);
    line.finish();
    ElementLaw law = VoltageControlledVoltageSource{gain, control_positive, control_negative};
    if (limit < unlimited) {
      law = LimitedVoltageControlledVoltageSource{gain, limit, control_positive, control_negative};
    }
    line.add("", positive, negative, law);
  } else {
    const double m = take_multiplicity(line);
    line.finish();
    line.add("", positive, negative,
             VoltageControlledCurrentSource{gain * m, control_positive, control_negative});
  }
}

void read_current_controlled(Line& line, bool is_voltage) {
  const NodeId positive = line.take_node("the positive node");
  const NodeId negative = line.take_node("the negative node");
  const bool polynomial = take_polynomial(line);
  const std::string control = line.take_word("the voltage source whose current controls");
  double gain = take_gain(line, polynomial);
  if (!is_voltage) gain *= take_multiplicity(line);
  line.finish();
  ElementLaw law = CurrentControlledCurrentSource{gain, {}};
  if (is_voltage) law = CurrentControlledVoltageSource{gain, {}};
  line.builder().add_controlled(line.make_element("", positive, negative, law),
                                line.instance().prefix, control);
}

void read_nullor(Line& line) {
  const NodeId positive = line.take_node("the output");
  const NodeId negative = line.take_node("the output's return");
  const NodeId control_positive = line.take_node("the positive input");
  const NodeId control_negative = line.take_node("the negative input");
  line.finish();
  line.add("", positive, negative, IdealOpAmp{control_positive, control_negative});
}

// Stiff against the pole's 1 ohm, so that it comes back a thousand times faster than its own time.
void read_pole_clamp(Line& line) {
  constexpr double resistance = 1e-3;
  const NodeId positive = line.take_node("the positive node");
  const NodeId negative = line.take_node("the negative node");
  const double limit = line.take_number("the limit");
  line.finish();
  if (!(limit > 0)) line.refuse(fmt::format("an op-amp's Vmax of {:g} V: must be positive", limit));
  if (limit < unlimited) line.add("", positive, negative, VoltageClamp{limit, resistance});
}

struct Kind {
  char letter;
  std::string_view name;
  void (*read)(Line&);  ///< null for what is known and not read
};

// Every letter that an element may begin with.
constexpr std::array kinds{
    Kind{'r', "resistors", read_resistor},
    Kind{'c', "capacitors", read_capacitor},
    Kind{'l', "inductors", read_inductor},
    Kind{'k', "couplings of inductors", read_coupling},
    Kind{'v', "voltage sources", read_voltage_source},
    Kind{'i', "current sources", read_current_source},
    Kind{'e', "voltage-controlled voltage sources",
         [](Line& line) { read_voltage_controlled(line, true); }},
    Kind{'g', "voltage-controlled current sources",
         [](Line& line) { read_voltage_controlled(line, false); }},
    Kind{'f', "current-controlled current sources",
         [](Line& line) { read_current_controlled(line, false); }},
    Kind{'h', "current-controlled voltage sources",
         [](Line& line) { read_current_controlled(line, true); }},
    Kind{'x', "subcircuits",
         [](Line& line) { line.builder().add_instance(line.card(), line.instance()); }},
    Kind{'d', "diodes", read_spice_diode},
    Kind{'@', "nullors", read_nullor},     // of the built-in library only
    Kind{'^', "clamps", read_pole_clamp},  // likewise
    Kind{'a', "special functions and XSPICE devices", nullptr},
    Kind{'b', "behavioural sources", nullptr},
    Kind{'j', "junction transistors", nullptr},
    Kind{'m', "MOS transistors", nullptr},
    Kind{'o', "lossy lines", nullptr},
    Kind{'q', "bipolar transistors", nullptr},
    Kind{'s', "switches", nullptr},
    Kind{'t', "transmission lines", nullptr},
    Kind{'u', "RC lines", nullptr},
    Kind{'w', "switches", nullptr},
    Kind{'z', "MES transistors", nullptr},
};

bool is_internal(char letter) {
  return letter == '@' || letter == '^';
}

std::string describe_kinds() {
  std::vector<std::string> names;
  for (const Kind& kind : kinds) {
    if (kind.read == nullptr || is_internal(kind.letter)) continue;
    names.push_back(fmt::format("{} ({})", static_cast<char>(kind.letter - 'a' + 'A'), kind.name));
  }
  return join(names);
}

}  // namespace

void read_spice_element(const SpiceCard& card, SpiceInstance& instance, SpiceBuilder& builder) {
  const std::string name = card.words.empty() ? std::string{} : lower_spice(card.words.front());
  const auto* const kind = std::find_if(kinds.begin(), kinds.end(), [&](const Kind& k) {
    return !name.empty() && k.letter == name[0] &&
           (!is_internal(k.letter) || instance.definition->built_in);
  });
  if (kind == kinds.end() || kind->read == nullptr) {
    throw Error(
        ErrorCode::bad_input, card.place,
        fmt::format("'{}': {} are not read: allowed: {}", card.text,
                    kind == kinds.end() ? "lines of this kind" : kind->name, describe_kinds()));
  }
  Line line(card, instance, builder);
  kind->read(line);
}

}  // namespace gyrator
