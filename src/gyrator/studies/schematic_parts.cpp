#include "gyrator/studies/schematic_parts.hpp"

#include "gyrator/core/text.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/model_format.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

namespace gyrator {
namespace {

std::string ohms(double value) {
  return print_quantity(value, dimension::resistance);
}
std::string hertz(double value) {
  return print_quantity(value, dimension::frequency);
}
std::string seconds(const Rational& time) {
  return print_quantity(time.to_double(), dimension::time);
}

// The motion's own words and letters.
struct Terms {
  explicit Terms(Motion motion) : units(units_of(motion)), rotary(motion == Motion::rotary) {}

  std::string inertia(double value) const { return print_quantity(value, units.inertia); }
  std::string damping(double value) const { return print_quantity(value, units.damping); }
  std::string stiffness(double value) const { return print_quantity(value, units.stiffness); }
  std::string effort(double value) const { return print_quantity(value, units.effort); }
  std::string mass_letter() const { return rotary ? "J" : "m"; }
  std::string mass_word() const { return rotary ? "inertia" : "mass"; }
  std::string effort_letter() const { return rotary ? "τ" : "F"; }
  std::string effort_word() const { return rotary ? "torque" : "force"; }
  std::string velocity_letter() const { return rotary ? "ω" : "v"; }

  Part make_mass(const std::string& what, const std::string& index, double value) const {
    return {Symbol::mass, what, mass_letter() + index, {inertia(value)}};
  }
  Part make_damper(const std::string& what, const std::string& index, double value) const {
    return {Symbol::damper, what, "b" + index, {damping(value)}};
  }
  Part make_spring(const std::string& what, const std::string& index, double value) const {
    return {Symbol::spring, what, "k" + index, {stiffness(value)}};
  }

  const MotionUnits& units;
  bool rotary;
};

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
  const Terms& terms;
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
  const Terms& terms;

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

// ---- Controllers and velocity estimators ------------------------------------------------------

struct EstimatorLines {
  const Terms& terms;
  BlockText& lines;

  void operator()(const DifferenceEstimator& e) const {
    lines.push_back("velocity: difference");
    if (e.window > 1) lines.push_back(fmt::format("over {} samples", e.window));
  }
  void operator()(const FilteredDifferenceEstimator& e) const {
    lines.push_back("velocity: difference,");
    lines.push_back("low-pass " + hertz(e.cutoff_hz));
  }
  void operator()(const ButterworthEstimator& e) const {
    lines.push_back("velocity: difference,");
    lines.push_back(fmt::format("Butterworth, order {},", e.order));
    lines.push_back(hertz(e.cutoff_hz));
  }
  void operator()(const AdaptiveWindowEstimator& e) const {
    lines.push_back("velocity: FOAW,");
    lines.push_back(fmt::format("{}-fit, window to {},", e.fit == WindowFit::end ? "end" : "best",
                                e.max_window));
    lines.push_back("noise " + print_quantity(e.noise, terms.units.position));
  }
  void operator()(const LevantEstimator& e) const {
    lines.push_back("velocity: Levant,");
    lines.push_back("L " + print_quantity(e.acceleration_bound, terms.units.acceleration));
  }
};

struct ControllerLines {
  const Terms& terms;
  bool held;  // only its gains are computed; an analog loop does the rest

  BlockText operator()(const NoController&) const { return {"no controller", "command 0"}; }

  BlockText operator()(const VirtualWall& wall) const {
    BlockText lines{held ? "gains of the wall" : "virtual wall",
                    "K " + terms.stiffness(wall.stiffness), "B " + terms.damping(wall.damping)};
    if (held) return lines;
    if (wall.damping != 0) std::visit(EstimatorLines{terms, lines}, wall.velocity);
    if (wall.unilateral) lines.push_back(wall.no_pull ? "unilateral, no pull" : "unilateral");
    return lines;
  }

  BlockText operator()(const PredictiveWall& wall) const {
    BlockText lines{"predictive wall", "K " + terms.stiffness(wall.stiffness),
                    "B " + terms.damping(wall.damping)};
    if (wall.prediction == PredictiveWall::Prediction::half_sample)
      lines.emplace_back("half a sample ahead");
    if (wall.dead_beat) lines.emplace_back("dead-beat at the surface");
    return lines;
  }

  BlockText operator()(const WaveController& wave) const {
    BlockText lines{"wave line"};
    if (const auto* wall = std::get_if<WaveWall>(&wave.environment)) {
      lines.push_back("K " + terms.stiffness(wall->stiffness));
      lines.push_back("B " + terms.damping(wall->damping));
      if (wall->unilateral) lines.emplace_back("unilateral");
    } else {
      lines.emplace_back("matched end");
    }
    return lines;
  }

  BlockText operator()(const VirtualCoupling& coupling) const {
    BlockText lines{"virtual coupling", "K " + terms.stiffness(coupling.coupling.stiffness),
                    "B " + terms.damping(coupling.coupling.damping),
                    "tool " + terms.inertia(coupling.tool_inertia)};
    if (coupling.wall) lines.push_back("wall " + terms.stiffness(coupling.wall->law.stiffness));
    add_update(lines, coupling.update);
    return lines;
  }

  BlockText operator()(const DirectRendering& law) const {
    return describe_object("direct rendering", law.scene);
  }
  BlockText operator()(const ProxyRendering& law) const {
    return describe_object("proxy", law.scene);
  }
  BlockText operator()(const EquivalentImpedance& law) const {
    return describe_object("equivalent impedance", law.scene);
  }

  BlockText describe_object(const char* title, const DeformableScene& scene) const {
    BlockText lines{title, "object " + terms.inertia(scene.object.inertia),
                    terms.stiffness(scene.object.to_ground.stiffness),
                    "contact " + terms.stiffness(scene.contact.stiffness)};
    add_update(lines, scene.update);
    return lines;
  }

  static void add_update(BlockText& lines, const SlowUpdate& update) {
    if (update.period) lines.push_back("every " + seconds(*update.period));
  }
};

// What is wrapped around a law, each a block of its own behind it.
struct WrapperLines {
  const Terms& terms;

  BlockText operator()(const PreEmphasis& /*stage*/) const { return {"pre-emphasis"}; }

  BlockText operator()(const BrakingPulse& pulse) const {
    return {"braking pulse", terms.damping(pulse.damping)};
  }
  BlockText operator()(const EventTransient& transient) const {
    return {"event transient", terms.damping(transient.gain), hertz(transient.frequency_hz)};
  }
  BlockText operator()(const AccelerationMatching& matching) const {
    return {"acceleration matching", "for " + terms.inertia(matching.inertia)};
  }

  BlockText operator()(const PassivityControl& control) const {
    const bool simple = control.observer == PassivityControl::Observer::simple;
    BlockText lines{"passivity control", simple ? "simple observer" : "reference energy"};
    if (control.max_damping) lines.push_back("up to " + terms.damping(*control.max_damping));
    if (control.max_effort) lines.push_back("up to " + terms.effort(*control.max_effort));
    return lines;
  }
};

// ---- Operators --------------------------------------------------------------------------------

struct OperatorParts {
  Diagram& diagram;
  const Terms& terms;

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

MotorParts describe_motor(const Motor& motor, const Terms& terms) {
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

void describe_mechanics(Diagram& diagram, const Mechanics& mechanics, const Terms& terms) {
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

BlockText describe_sensor(const Sensor& sensor, const Terms& terms) {
  BlockText lines{"position sensor"};
  if (sensor.quantum > 0)
    lines.push_back("step " + print_quantity(sensor.quantum, terms.units.quantum));
  if (sensor.offset != 0)
    lines.push_back("offset " + print_quantity(sensor.offset, terms.units.position));
  return lines;
}

ComputerParts describe_computer(const Model& model, const Terms& terms) {
  const bool held = find_held_impedance(model.device) != nullptr;
  ComputerParts parts;
  if (held) parts.sampled = Sampled::nothing;
  if (std::holds_alternative<WaveController>(model.controller.law))
    parts.sampled = Sampled::terminal_voltage;
  parts.period = "T " + seconds(model.sampling.period);
  parts.blocks.push_back(std::visit(ControllerLines{terms, held}, model.controller.law));
  for (const Wrapper& wrapper : model.controller.wrappers)
    parts.blocks.push_back(std::visit(WrapperLines{terms}, wrapper));
  if (model.sampling.delay > Rational(0))
    parts.blocks.push_back({"delay", seconds(model.sampling.delay)});
  parts.blocks.push_back({"hold"});
  return parts;
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
  const Terms terms(device.motion);
  Diagram diagram;
  diagram.title = model.name;
  const bool analog = find_held_impedance(device) != nullptr;  // steps are the computer's
  diagram.sensor = describe_sensor(analog ? Sensor{} : model.sensor, terms);
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
