#include "gyrator/circuits/spice_diode.hpp"

#include <string_view>

#include <fmt/core.h>

namespace gyrator {
namespace {

// SPICE's temperature, 27 degC, at which it states a model's parameters.
constexpr double temperature = 300.15;  // [K]
constexpr double thermal_voltage = 1.380649e-23 * temperature / 1.602176634e-19;

struct Unread {
  std::string_view name, what;
};

// Zero says that the effect is not there.
constexpr Unread unread[] = {
    {"cjo", "junction capacitance"},  {"cj0", "junction capacitance"},
    {"cjsw", "sidewall capacitance"}, {"cjp", "sidewall capacitance"},
    {"tt", "stored charge"},          {"ikf", "high-level injection"},
    {"ik", "high-level injection"},   {"ikr", "high-level injection"},
    {"isr", "recombination"},         {"jsw", "sidewall current"},
};
// Given at all they mean another law.
constexpr Unread other_laws[] = {
    {"bv", "breakdown"},
    {"vb", "breakdown"},
    {"vrev", "breakdown"},
    {"ron", "LTspice's piecewise linear diode"},
    {"roff", "LTspice's piecewise linear diode"},
    {"vfwd", "LTspice's piecewise linear diode"},
    {"ilimit", "LTspice's limited current"},
    {"revilimit", "LTspice's limited current"},
};

struct Junction {
  Diode law;
  double resistance = 0;
};

Junction read_model(const SpiceModelUse& use, SpiceBuilder& builder) {
  SpiceElementLine model(use.model->card, *use.around, builder);
  for (const Unread& u : unread) {
    if (model.take_value(u.name).value_or(0) == 0) continue;
    model.refuse(fmt::format("{}: a diode's {} is not read: 0 leaves it out", u.name, u.what));
  }
  for (const Unread& u : other_laws) {
    if (!model.take_value(u.name)) continue;
    model.refuse(
        fmt::format("{}: a diode's {} is not read: drop it to leave it out", u.name, u.what));
  }
  for (const std::string_view name : {"tnom", "tref"}) {
    const auto at = model.take_value(name);
    if (at && *at != 27) {
      model.refuse(fmt::format("{} = {:g} degC: parameters hold at 27 degC", name, *at));
    }
  }
  const auto level = model.take_value("level");
  if (level && *level != 1) model.refuse(fmt::format("level = {:g}: level 1 is read", *level));
  model.ignore({"mfg", "type", "pn", "iave", "irms", "ipk", "vpk", "diss"});  // documentation
  model.ignore(
      {"m", "mj", "vj", "pb", "fc", "mjsw", "vjsw", "php", "fcs"});    // of Cjo's, which is 0
  model.ignore({"ibv", "nbv", "ibvl", "nbvl", "tbv1", "tbv2", "nr"});  // of Bv's and Isr's
  model.ignore({"xti", "eg", "trs1", "trs2", "trs", "tikf"});          // at 27 degC nothing
  model.ignore({"kf", "af"});                                          // noise
  Junction junction;
  junction.law.saturation_current = model.take_part("is", true).value_or(1e-14);
  junction.law.emission_voltage = model.take_part("n", true).value_or(1) * thermal_voltage;
  junction.resistance = model.take_part("rs").value_or(0);
  model.finish();
  return junction;
}

}  // namespace

void read_spice_diode(SpiceElementLine& line) {
  const NodeId anode = line.take_node("the anode");
  const NodeId cathode = line.take_node("the cathode");
  const std::string name = line.take_word("the .model's name");
  const SpiceModelUse use = line.builder().find_model(line.card(), name, line.instance());
  if (use.model->type != "d") {
    line.refuse(fmt::format("{} at {} is a model of type '{}': a diode takes one of type D",
                            use.model->name, use.model->place, use.model->type));
  }
  double area = line.take_part("area", true).value_or(1);
  if (line.has_word() && line.peek() != "off") area = line.take_number("the area");
  if (line.peek() == "off") line.take_word("");  // where a search begins, not where it ends
  if (!(area > 0)) line.refuse(fmt::format("an area of {:g}: must be positive", area));
  area *= line.take_part("m", true).value_or(1);
  line.finish();

  Junction junction = read_model(use, line.builder());
  junction.law.saturation_current *= area;
  NodeId inner = anode;
  if (junction.resistance > 0) {
    inner = line.add_inner_node(".rs");
    line.add(".rs", anode, inner, Resistor{junction.resistance / area});
  }
  line.add("", inner, cathode, junction.law);
}

}  // namespace gyrator
