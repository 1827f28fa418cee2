#include "gyrator/studies/schematic.hpp"

#include "gyrator/core/quantity.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/studies/schematic_layout.hpp"

#include <algorithm>
#include <set>
#include <sstream>
#include <string>

#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

const std::vector<Damping>& every_damping() {
  static const std::vector<Damping> list{
      ResistorDamping{1.23456e6},
      RcDamping{.resistance = 5, .capacitance = 2200e-6},
      ResistanceCancellation{.resistance = 1.35, .bandwidth_hz = 1999.99},
      BackEmfDamping{.damping = 1.23456e-3,
                     .resistance_estimate = 1.5,
                     .inductance_estimate = 0.5e-3,
                     .low_pass_hz = 300,
                     .high_pass_hz = 1},
      HeldImpedance{.stiffness = 0.4, .damping = 1.5e-4, .bandwidth_hz = 1e3},
      TorqueSensedDamper{.damping = 1e-3, .cutoff_hz = 123.456},
      EddyCurrentBrake{.damping = 1e-3, .on = false},
      HighPassDamper{.inertia = 1.23456e-7, .damping = 1.23456e-3},
      NetlistDamping{parse_subcircuit("* r\n.subckt a_subcircuit_with_a_long_name 1 2\nR1 1 2 5\n"
                                      ".ends\n",
                                      "a folder/a file with a very long name.cir", "")},
      WaveDamping{.impedance = 1.23456e-4},
      ClampDamping{.voltage = 12.3456},
      FrictionBrake{.damping = 1.23456e-3, .effort = 1.23456e-2},
  };
  return list;
}

// What a drive may have but once (check_drive).
bool stands_alone(const Damping& damping) {
  return std::holds_alternative<ResistanceCancellation>(damping) ||
         std::holds_alternative<BackEmfDamping>(damping) ||
         std::holds_alternative<HeldImpedance>(damping) ||
         std::holds_alternative<WaveDamping>(damping);
}

// None, each alone, every two, and all at once.
std::vector<std::vector<Damping>> make_mixtures() {
  const auto& every = every_damping();
  std::vector<std::vector<Damping>> mixtures{{}, every};
  for (std::size_t i = 0; i < every.size(); ++i) {
    mixtures.push_back({every[i]});
    for (std::size_t j = 0; j < every.size(); ++j)
      if (i != j || !stands_alone(every[i])) mixtures.push_back({every[i], every[j]});
  }
  const RcDamping capacitor{.capacitance = 47e-9};
  mixtures.push_back({every[1], every[0], capacitor, every[1]});
  return mixtures;
}

std::vector<Amplifier> make_amplifiers() {
  return {IdealDrive{},
          CurrentAmplifier{},
          CurrentAmplifier{.bandwidth_hz = 1234.56},
          CurrentAmplifier{.bandwidth_hz = {}, .sense = CurrentSense::motor},
          CurrentAmplifier{.bandwidth_hz = 100, .sense = CurrentSense::motor},
          VoltageAmplifier{},
          VoltageAmplifier{.bandwidth_hz = 800, .output_resistance = 0.7}};
}

std::vector<Operator> make_operators() {
  return {FreeOperator{}, ClampedOperator{},
          MassSpringDamper{.inertia = 5e-6, .damping = 1e-4, .stiffness = 0.05, .resonators = {}},
          MassSpringDamper{.resonators = {{.inertia = 1.23456e-6, .stiffness = 12.3456}}}};
}

std::vector<Controller> make_controllers() {
  VirtualWall filtered{.stiffness = 123456, .damping = -1.5e-4};
  filtered.velocity = FilteredDifferenceEstimator{.cutoff_hz = 100};
  filtered.unilateral = filtered.no_pull = true;
  VirtualWall windowed{.stiffness = 0.4, .damping = 1.5e-4};
  windowed.velocity = DifferenceEstimator{.window = 12};
  VirtualWall butterworth = windowed, adaptive = windowed, levant = windowed;
  butterworth.velocity = ButterworthEstimator{.order = 4, .cutoff_hz = 123.456};
  adaptive.velocity = AdaptiveWindowEstimator{.noise = 7.67e-4, .max_window = 32};
  levant.velocity = LevantEstimator{.acceleration_bound = 123.456};
  return {NoController{}, VirtualWall{.stiffness = 0.4}, filtered, windowed, butterworth, adaptive,
          levant};
}

std::vector<Controller> make_wave_controllers() {
  const WaveWall wall{.stiffness = 123456, .damping = 1.5e-4, .unilateral = true};
  return {WaveController{.environment = wall}, WaveController{}, VirtualWall{.stiffness = 0.4}};
}

bool has_wave(const std::vector<Damping>& damping) {
  return std::any_of(damping.begin(), damping.end(),
                     [](const Damping& d) { return std::holds_alternative<WaveDamping>(d); });
}

Model make_model(const Device& device) {
  Model model;
  model.name = "RC-damped rotary display";
  model.device = device;
  model.controller = VirtualWall{.stiffness = 0.4, .damping = 1.5e-4};
  return model;
}

// Every amplifier with every mixture, rigid and compliant, while operators, controllers, sensors
// and motions take turns.
std::vector<Model> make_models() {
  std::vector<Model> models;
  const auto operators = make_operators();
  std::size_t turn = 0;
  for (const Amplifier& amplifier : make_amplifiers()) {
    for (const auto& damping : make_mixtures()) {
      // Only a voltage amplifier makes a wave drive (check_drive).
      const bool wave = has_wave(damping);
      if (wave && !std::holds_alternative<VoltageAmplifier>(amplifier)) continue;
      const auto controllers = wave ? make_wave_controllers() : make_controllers();
      for (const bool compliant : {false, true}) {
        Model model = make_model(testing::make_rc_display());
        Device& device = model.device;
        device.drive.amplifier = amplifier;
        device.drive.damping = damping;
        ++turn;
        if (turn % 3 == 0) device.drive.motor->inductance = 0;
        if (turn % 5 == 0) device.drive.motor->temperature_rise = 40;
        if (turn % 7 == 0) device.mechanics.coulomb_friction = 1e-3;
        if (turn % 4 == 1) device.motion = Motion::linear;
        if (turn % 4 > 1) device.sensor = SensorLocation::motor;
        if (compliant)
          device.mechanics.transmission = Transmission{
              .stiffness = 12.3456, .damping = turn % 3 == 1 ? 0 : 1e-3, .load_inertia = 1e-5};
        model.held_by = operators[turn % operators.size()];
        model.controller = controllers[turn / 4 % controllers.size()];
        if (turn % 6 == 0) model.external_effort = 3.45678e-3;
        if (turn % 5 == 1) model.sensor = {.quantum = 7.6699e-4, .offset = 1e-3};
        if (turn % 3 == 1) model.sampling = {Rational(1, 60), Rational(1, 3000)};
        models.push_back(model);
      }
    }
  }
  Model plain = make_model(testing::make_p3());
  plain.device.drive.damping = {every_damping()[4], every_damping()[5], every_damping()[6],
                                every_damping()[7]};
  models.push_back(plain);
  models.push_back(make_model(testing::make_p3()));
  return models;
}

bool overlap(const TextBox& a, const TextBox& b) {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

// Whether a straight line passes through the box: what the box leaves of it (Liang and Barsky
// 1984).
bool meets(const Stroke& stroke, const TextBox& box) {
  double from = 0;
  double to = 1;
  const auto cut = [&](double along, double distance) {  // keeps t where along * t <= distance
    if (along > 0) to = std::min(to, distance / along);
    if (along < 0) from = std::max(from, distance / along);
    if (along == 0 && distance < 0) to = -1;
  };
  const double dx = stroke.to.x - stroke.from.x;
  const double dy = stroke.to.y - stroke.from.y;
  cut(-dx, stroke.from.x - box.left);
  cut(dx, box.right - stroke.from.x);
  cut(-dy, stroke.from.y - box.top);
  cut(dy, box.bottom - stroke.from.y);
  return from <= to;
}

std::set<std::string> texts_of(const Schematic& schematic) {
  std::set<std::string> texts;
  for (const TextBox& box : schematic.texts) texts.insert(box.text);
  return texts;
}

TEST(Schematic, TheListOfTheseTestsHoldsEveryKindOfDamping) {
  std::set<std::size_t> kinds;
  for (const Damping& damping : every_damping()) kinds.insert(damping.index());
  EXPECT_EQ(kinds.size(), std::variant_size_v<Damping>);
}

void expect_nothing_overlaps(const Diagram& diagram) {
  const Schematic schematic = SchematicLayout(diagram).draw();
  const std::string what = describe_in_words(diagram);
  for (std::size_t i = 0; i < schematic.texts.size(); ++i) {
    const TextBox& box = schematic.texts[i];
    ASSERT_TRUE(box.left >= 0 && box.top >= 0 && box.right <= schematic.width &&
                box.bottom <= schematic.height)
        << box.text << " in " << what;
    for (std::size_t j = 0; j < i; ++j)
      ASSERT_FALSE(overlap(box, schematic.texts[j]))
          << box.text << " and " << schematic.texts[j].text << " in " << what;
    for (const Stroke& stroke : schematic.strokes)
      ASSERT_FALSE(meets(stroke, box)) << box.text << " and a line from " << stroke.from.x << ", "
                                       << stroke.from.y << " in " << what;
  }
  for (const Stroke& stroke : schematic.strokes)
    ASSERT_TRUE(stroke.from.x >= 0 && stroke.from.y >= 0 && stroke.from.x <= schematic.width &&
                stroke.from.y <= schematic.height)
        << stroke.from.x << ", " << stroke.from.y << " in " << what;
}

TEST(Schematic, NoTextMeetsATextOrAStrokeAndAllIsOnTheCanvas) {
  for (const Model& model : make_models()) {
    expect_nothing_overlaps(describe_device(model));
    if (HasFatalFailure()) return;
  }
}

TEST(Schematic, AComputerMayReadTheTerminalVoltageInsteadOfThePosition) {
  for (Model model : make_models()) {
    if (!model.device.drive.motor || find_held_impedance(model.device)) continue;
    Diagram diagram = describe_device(model);
    diagram.computer.sampled = Sampled::terminal_voltage;
    expect_nothing_overlaps(diagram);
    if (HasFatalFailure()) return;
    EXPECT_FALSE(texts_of(SchematicLayout(diagram).draw()).contains("position sensor"));
  }
}

TEST(Schematic, EveryLabelOfEveryPartIsDrawn) {
  for (const Model& model : make_models()) {
    const Diagram d = describe_device(model);
    const auto texts = texts_of(draw_schematic(model));
    std::vector<std::string> wanted{d.computer.period};
    const auto add_part = [&](const Part& part) {
      if (!part.name.empty()) wanted.push_back(part.name);
      wanted.insert(wanted.end(), part.values.begin(), part.values.end());
    };
    const auto add_lines = [&](const BlockText& lines) {
      wanted.insert(wanted.end(), lines.begin(), lines.end());
    };
    for (const auto* list : {&d.across, &d.at_shaft, &d.at_load, &d.at_port, &d.held_by})
      for (const Branch& branch : *list) std::for_each(branch.begin(), branch.end(), add_part);
    for (const auto* list : {&d.amplifier_output, &d.transmission})
      std::for_each(list->begin(), list->end(), add_part);
    add_part(d.amplifier);
    for (const SeriesPart& s : d.in_series) {
      if (!d.motor) continue;
      add_part(s.part);
      add_lines(s.feedback);
    }
    if (d.motor) std::for_each(d.motor->winding.begin(), d.motor->winding.end(), add_part);
    if (d.motor) add_lines(d.motor->gyrator);
    for (const Feedback& f : d.feedback) std::for_each(f.blocks.begin(), f.blocks.end(), add_lines);
    std::for_each(d.amplifier_loop.begin(), d.amplifier_loop.end(), add_lines);
    std::for_each(d.computer.blocks.begin(), d.computer.blocks.end(), add_lines);
    if (d.computer.sampled == Sampled::position) add_lines(d.sensor);
    for (const auto& text : wanted)
      ASSERT_TRUE(texts.contains(text)) << text << " in " << describe_in_words(d);
  }
}

TEST(Schematic, ShowsTheValuesOfEveryKindOfDampingWithTheirUnits) {
  Model model = make_model(testing::make_rc_display());
  model.device.drive.amplifier = VoltageAmplifier{.bandwidth_hz = 800, .output_resistance = 0.7};
  model.device.drive.damping = every_damping();
  model.device.mechanics.transmission =
      Transmission{.stiffness = 20, .damping = 2e-3, .load_inertia = 3e-5};
  const auto texts = texts_of(draw_schematic(model));
  for (const char* text : {"800 Hz",
                           "700 mΩ",
                           "1.23456 MΩ",
                           "5 Ω",
                           "2.2 mF",
                           "1.35 Ω",
                           "low-pass 1.99999 kHz",
                           "R\u0302 1.5 Ω",
                           "L\u0302 500 µH",
                           "300 Hz",
                           "1 Hz",
                           "1.23456 mN·m·s/rad",
                           "k 400 mN·m/rad",
                           "d 150 µN·m·s/rad",
                           "low-pass 1 kHz",
                           "123.456 Hz",
                           "switched off",
                           "1.23456×10⁻⁷ kg·m²",
                           "1.5 Ω",
                           "500 µH",
                           "50 mN·m/A",
                           "2×10⁻⁵ kg·m²",
                           "100 µN·m·s/rad",
                           "20 N·m/rad",
                           "2 mN·m·s/rad",
                           "3×10⁻⁵ kg·m²",
                           "T 1 ms"})
    EXPECT_TRUE(texts.contains(text)) << text;
}

TEST(Schematic, TheSameModelGivesTheSameBytes) {
  const Model model = make_model(testing::make_rc_display());
  EXPECT_EQ(draw_schematic(model).svg, draw_schematic(model).svg);
}

TEST(Schematic, IsWellFormedAndEscapesTheModelsName) {
  Model model = make_model(testing::make_rc_display());
  model.name = "</title><script>alert('1')</script> & \"" + std::string(300, 'W') + "Ä\xff";
  const Schematic schematic = draw_schematic(model);
  std::istringstream stream(schematic.svg);
  boost::property_tree::ptree tree;
  boost::property_tree::read_xml(stream, tree);
  EXPECT_EQ(tree.get<std::string>("svg.title").substr(0, 40),
            "</title><script>alert('1')</script> & \"W");
  EXPECT_NE(tree.get<std::string>("svg.desc").find("capacitor across the motor 2.2 mF"),
            std::string::npos);
  EXPECT_EQ(schematic.svg.find("<script"), std::string::npos);
  const TextBox& title = schematic.texts.back();
  EXPECT_TRUE(title.text.ends_with("…"));
  EXPECT_LE(title.right, schematic.width);
}

TEST(Schematic, FeedbacksLieOneInsideTheNext) {
  Model model = make_model(testing::make_rc_display());
  model.device.drive.damping = {every_damping()[5], every_damping()[4], every_damping()[3]};
  const Diagram diagram = describe_device(model);
  ASSERT_EQ(diagram.feedback.size(), 3U);
  EXPECT_EQ(diagram.feedback[0].tap, Tap::back_emf);
  EXPECT_EQ(diagram.feedback[1].tap, Tap::position);
  EXPECT_EQ(diagram.feedback[2].tap, Tap::effort);
}

TEST(Schematic, AQuantityIsPrintedWithTheSignsOfItsUnit) {
  EXPECT_EQ(print_quantity(1e-4, dimension::rotary_damping), "100 µN·m·s/rad");
  EXPECT_EQ(print_quantity(4700, dimension::resistance), "4.7 kΩ");
  EXPECT_EQ(print_quantity(2e-5, dimension::inertia), "2×10⁻⁵ kg·m²");
  EXPECT_EQ(print_quantity(-2.5, dimension::torque), "−2.5 N·m");
  EXPECT_EQ(print_quantity(0, dimension::resistance), "0 Ω");
}

}  // namespace
}  // namespace gyrator
