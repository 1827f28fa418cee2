#include "gyrator/studies/schematic_parts.hpp"

#include "gyrator/core/text.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/schematic_computer.hpp"
#include "gyrator/studies/schematic_terms.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

namespace gyrator {
namespace {

// ---- Damping: one function per kind; without one, std::visit does not compile. ----------------

constexpr double widest_file = 160;  // pixels; a longer name is cut

// A box with the file's and the subcircuit's name.
Part make_subcircuit(const char* what, const SpiceCircuit& circuit) {
  const std::string place = circuit.place.substr(0, circuit.place.rfind(':'));
  const std::string file = std::filesystem::path(place).filename().string();
  return {
      Symbol::box, what, "", {fit_text(file, widest_file), fit_text(circuit.name, widest_file)}};
}

struct DampingParts {
  Diagram& diagram;
  const SchematicTerms& terms;
  const Drive& drive;
  std::string index;  // "_1"

  void operator()(const ResistorDamping& d) const {
    diagram.across.push_back(
        {{Symbol::resistor, "resistor across the motor", "R" + index, {ohms(d.resistance)}}});
  }

  void operator()(const RcDamping& d) const {
    Branch branch;
    if (d.resistance > 0)
      branch.push_back(
          {Symbol::resistor, "resistor across the motor", "R" + index, {ohms(d.resistance)}});
    branch.push_back({Symbol::capacitor,
                      "capacitor across the motor",
                      "C" + index,
                      {print_quantity(d.capacitance, dimension::capacitance)}});
    diagram.across.push_back(branch);
  }

  void operator()(const NetlistDamping& d) const {
    diagram.across.push_back({make_subcircuit("SPICE subcircuit across the motor", d.circuit)});
  }

  void operator()(const ClampDamping& d) const {
    diagram.across.push_back(
        {{Symbol::clamp,
          "clamp across the motor",
          "D" + index,
          {print_quantity(d.voltage, dimension::voltage), ohms(d.resistance)}}});
  }

  void operator()(const FrictionBrake& d) const {
    diagram.at_port.push_back({{Symbol::friction,
                                "friction brake",
                                "b" + index,
                                {terms.damping(d.damping), "up to " + terms.effort(d.effort)}}});
  }

  void operator()(const ResistanceCancellation& d) const {
    BlockText block{"R_c i"};
    if (d.bandwidth_hz) block.push_back("low-pass " + hertz(*d.bandwidth_hz));
    diagram.in_series.push_back(
        {{Symbol::controlled_voltage, "resistance cancellation", "−R_c", {ohms(d.resistance)}},
         block});
  }

  // Drawn with what the amplifier's own output resistance leaves of it.
  void operator()(const WaveDamping& d) const {
    double resistance = drive.motor->torque_constant * drive.motor->torque_constant / d.impedance;
    if (const auto* amplifier = std::get_if<VoltageAmplifier>(&drive.amplifier))
      resistance -= amplifier->output_resistance;
    diagram.amplifier_output.push_back({Symbol::resistor,
                                        "source resistance of the waves",
                                        "R_w",
                                        {ohms(resistance), terms.damping(d.impedance)}});
  }

  void operator()(const BackEmfDamping& d) const {
    BlockText estimate{"back-EMF estimate", "R\u0302 " + ohms(d.resistance_estimate)};
    if (d.inductance_estimate > 0)
      estimate.push_back("L\u0302 " + print_quantity(d.inductance_estimate, dimension::inductance));
    Feedback feedback{Tap::back_emf, {estimate}};
    if (d.low_pass_hz) feedback.blocks.push_back({"low-pass", hertz(*d.low_pass_hz)});
    if (d.high_pass_hz) feedback.blocks.push_back({"high-pass", hertz(*d.high_pass_hz)});
    feedback.blocks.push_back({"damping", terms.damping(d.damping)});
    diagram.feedback.push_back(feedback);
  }

  void operator()(const HeldImpedance& d) const {
    BlockText loop{"analog wall", "k " + terms.stiffness(d.stiffness),
                   "d " + terms.damping(d.damping)};
    if (d.bandwidth_hz) loop.push_back("low-pass " + hertz(*d.bandwidth_hz));
    Feedback feedback{Tap::position, {diagram.sensor, loop}};
    feedback.set_by_computer = true;
    diagram.feedback.push_back(feedback);
  }

  void operator()(const TorqueSensedDamper& d) const {
    const std::string what = terms.effort_word() + "-sensed damper";
    Part sensor{Symbol::meter, terms.effort_word() + " sensor", "", {}, terms.effort_letter()};
    diagram.at_port.push_back({sensor, terms.make_damper(what, index, d.damping)});
    Feedback feedback{Tap::effort, {{"low-pass", hertz(d.cutoff_hz)}}, '+'};
    feedback.branch = diagram.at_port.size() - 1;
    diagram.feedback.push_back(feedback);
  }

  void operator()(const EddyCurrentBrake& d) const {
    diagram.at_port.push_back({{Symbol::brake,
                                "eddy-current brake",
                                "b" + index,
                                {terms.damping(d.damping), d.on ? "on" : "switched off"}}});
  }

  void operator()(const HighPassDamper& d) const {
    diagram.at_port.push_back({terms.make_damper("high-pass damper", index, d.damping),
                               terms.make_mass("floating " + terms.mass_word(), index, d.inertia)});
  }
};

// ---- Amplifiers -------------------------------------------------------------------------------

struct AmplifierParts {
  Diagram& diagram;
  const SchematicTerms& terms;

  void operator()(const IdealDrive&) const {
    diagram.amplifier = {Symbol::current_source,
                         "ideal " + terms.effort_word() + " source",
                         "",
                         {"ideal", terms.effort_word() + " source"}};
    diagram.amplifier_at_shaft = true;
  }

  void operator()(const CurrentAmplifier& a) const {
    diagram.amplifier = {Symbol::current_source, "current amplifier", "", {"current", "amplifier"}};
    const bool senses_motor = a.sense == CurrentSense::motor;
    if (senses_motor) diagram.feedback.push_back({Tap::motor_current, {}});
    if (a.bandwidth_hz)
      diagram.amplifier_loop.push_back(
          {senses_motor ? "current loop" : "low-pass", hertz(*a.bandwidth_hz)});
    else if (senses_motor)
      diagram.amplifier_loop.push_back({"current loop", "ideal"});
  }

  void operator()(const VoltageAmplifier& a) const {
    diagram.amplifier = {Symbol::voltage_source, "voltage amplifier", "", {"voltage", "amplifier"}};
    if (a.bandwidth_hz) diagram.amplifier_loop.push_back({"low-pass", hertz(*a.bandwidth_hz)});
    if (a.output_resistance > 0)
      diagram.amplifier_output.push_back(
          {Symbol::resistor, "output resistance", "R_o", {ohms(a.output_resistance)}});
  }
};

// ---- Operators --------------------------------------------------------------------------------

struct OperatorParts {
  Diagram& diagram;
  const SchematicTerms& terms;

  void operator()(const NetworkOperator& hand) const {
    diagram.operator_kind = "network";
    diagram.held_by.push_back({make_subcircuit("operator's network", hand.circuit)});
  }

  void operator()(const FreeOperator&) const { diagram.operator_kind = "free"; }

  void operator()(const ClampedOperator&) const {
    diagram.operator_kind = "clamped";
    diagram.held_by.emplace_back();
  }

  void operator()(const MassSpringDamper& hand) const {
    diagram.operator_kind = terms.mass_word() + ", spring and damper";
    auto& branches = diagram.held_by;
    if (hand.inertia > 0)
      branches.push_back({terms.make_mass("operator's " + terms.mass_word(), "_h", hand.inertia)});
    if (hand.damping > 0)
      branches.push_back({terms.make_damper("operator's damping", "_h", hand.damping)});
    if (hand.stiffness > 0)
      branches.push_back({terms.make_spring("operator's stiffness", "_h", hand.stiffness)});
    for (std::size_t i = 0; i < hand.resonators.size(); ++i) {
      const std::string index = fmt::format("_h{}", i + 1);
      branches.push_back(
          {terms.make_spring("operator's resonator, spring", index, hand.resonators[i].stiffness),
           terms.make_mass("operator's resonator", index, hand.resonators[i].inertia)});
    }
  }
};

// ---- What every model has ---------------------------------------------------------------------

MotorParts describe_motor(const Motor& motor, const SchematicTerms& terms) {
  MotorParts parts;
  Part resistance{Symbol::resistor, "winding resistance", "R_m", {ohms(motor.resistance)}};
  if (motor.temperature_rise != 0)
    resistance.values.push_back(
        fmt::format("{:+.4g} K: {}", motor.temperature_rise, ohms(motor.warm_resistance())));
  parts.winding.push_back(resistance);
  if (motor.inductance > 0)
    parts.winding.push_back({Symbol::inductor,
                             "winding inductance",
                             "L_m",
                             {print_quantity(motor.inductance, dimension::inductance)}});
  parts.gyrator = {"K_t", print_quantity(motor.torque_constant, terms.units.motor_constant),
                   "e = K_t " + terms.velocity_letter(), terms.effort_letter() + " = K_t i"};
  parts.what = terms.rotary ? "rotary motor" : "linear motor";
  return parts;
}

void describe_mechanics(Diagram& diagram, const Mechanics& mechanics, const SchematicTerms& terms) {
  diagram.at_shaft.push_back({terms.make_mass(terms.mass_word(), "", mechanics.inertia)});
  if (mechanics.damping > 0)
    diagram.at_shaft.push_back({terms.make_damper("viscous damping", "", mechanics.damping)});
  if (mechanics.coulomb_friction > 0)
    diagram.at_shaft.push_back({{Symbol::friction,
                                 "Coulomb friction",
                                 terms.effort_letter() + "_C",
                                 {terms.effort(mechanics.coulomb_friction)}}});
  if (!mechanics.transmission) return;
  const Transmission& t = *mechanics.transmission;
  diagram.transmission.push_back(terms.make_spring("transmission stiffness", "_t", t.stiffness));
  if (t.damping > 0)
    diagram.transmission.push_back(terms.make_damper("transmission damping", "_t", t.damping));
  diagram.at_load.push_back({terms.make_mass("load " + terms.mass_word(), "_L", t.load_inertia)});
}

// Each feedback's loop lies within the next one's: no two lines cross.
void nest(std::vector<Feedback>& feedback) {
  std::stable_sort(feedback.begin(), feedback.end(),
                   [](const Feedback& a, const Feedback& b) { return a.tap < b.tap; });
}

}  // namespace

std::string print_quantity(double value, const Unit& unit) {
  const std::string text = format_quantity(value, unit);
  const auto blank = text.find(' ');
  std::string symbol = blank == std::string::npos ? "" : pretty_unit(text.substr(blank + 1));
  if (symbol.starts_with('u')) symbol = "µ" + symbol.substr(1);
  const std::string number = pretty_number(std::strtod(text.substr(0, blank).c_str(), nullptr), 6);
  return symbol.empty() ? number : number + " " + symbol;
}

Diagram describe_device(const Model& model) {
  const Device& device = model.device;
  const SchematicTerms terms(device.motion);
  Diagram diagram;
  diagram.title = model.name;
  const bool analog = find_held_impedance(device) != nullptr;  // steps are the computer's
  diagram.sensor = describe_sensor(analog ? Sensor{} : model.sensor,
                                   analog ? std::nullopt : device.sensor_filter, terms);
  diagram.sensor_at_shaft =
      device.sensor == SensorLocation::motor && device.mechanics.transmission.has_value();
  std::visit(AmplifierParts{diagram, terms}, device.drive.amplifier);
  for (std::size_t i = 0; i < device.drive.damping.size(); ++i)
    std::visit(DampingParts{diagram, terms, device.drive, fmt::format("_{}", i + 1)},
               device.drive.damping[i]);
  if (device.drive.motor) diagram.motor = describe_motor(*device.drive.motor, terms);
  describe_mechanics(diagram, device.mechanics, terms);
  diagram.computer = describe_computer(model, terms);
  std::visit(OperatorParts{diagram, terms}, model.held_by);
  if (model.external_effort != 0)
    diagram.held_by.push_back({{Symbol::current_source,
                                "external " + terms.effort_word(),
                                terms.effort_letter() + "_e",
                                {terms.effort(model.external_effort)}}});
  if (model.gesture)
    diagram.held_by.push_back(
        {{Symbol::current_source, "gesture", terms.effort_letter() + "_g", {"of the hand"}}});
  nest(diagram.feedback);
  return diagram;
}

std::string describe_in_words(const Diagram& diagram) {
  std::vector<std::string> words;
  const auto add = [&](const Part& part) {
    const bool named = !part.name.empty();  // else the values are its name
    words.push_back(named ? part.what + " " + join(part.values) : part.what);
  };
  const auto add_all = [&](const std::vector<Branch>& branches) {
    for (const Branch& branch : branches) std::for_each(branch.begin(), branch.end(), add);
  };
  const auto add_blocks = [&](const std::vector<BlockText>& blocks) {
    for (const BlockText& block : blocks) words.push_back(join(block, " "));
  };
  add(diagram.amplifier);
  add_blocks(diagram.amplifier_loop);
  std::for_each(diagram.amplifier_output.begin(), diagram.amplifier_output.end(), add);
  add_all(diagram.across);
  for (const SeriesPart& s : diagram.in_series) {
    add(s.part);
    add_blocks({s.feedback});
  }
  if (diagram.motor) {
    words.push_back(diagram.motor->what + " " + diagram.motor->gyrator[0] + " " +
                    diagram.motor->gyrator[1]);
    std::for_each(diagram.motor->winding.begin(), diagram.motor->winding.end(), add);
  }
  add_all(diagram.at_shaft);
  std::for_each(diagram.transmission.begin(), diagram.transmission.end(), add);
  add_all(diagram.at_load);
  add_all(diagram.at_port);
  for (const Feedback& f : diagram.feedback) add_blocks(f.blocks);
  add_blocks({diagram.sensor});
  words.push_back("sampled, " + diagram.computer.period);
  add_blocks(diagram.computer.blocks);
  words.push_back("operator " + diagram.operator_kind);
  add_all(diagram.held_by);
  return join(words, "; ") + ".";
}

}  // namespace gyrator
