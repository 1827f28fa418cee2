#include "gyrator/studies/tolerance.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/passivity/port_response.hpp"
#include "gyrator/studies/model_file.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

json make_model(const json& damping, const char* amplifier = "current") {
  json model = {{"motion", "rotary"},
                {"motor",
                 {{"torque_constant", "50 mN.m/A ± 10 %"},
                  {"resistance", "2 ohm ± 5 %"},
                  {"inductance", "0.5 mH ± 10 %"},
                  {"temperature_rise", "0 K (-10 K to 40 K)"}}},
                {"mechanics", {{"inertia", "20 g.cm^2 ± 5 %"}, {"damping", "1e-5 ± 50 %"}}},
                {"amplifier", {{"kind", amplifier}}},
                {"damping", damping.is_null() ? json::array() : json::array({damping})},
                {"sampling", {{"period", "1 ms"}}},
                {"controller", {{"kind", "virtual_wall"}, {"stiffness", 0.01}}}};
  if (model["amplifier"]["kind"] == "voltage")
    model["amplifier"]["output_resistance"] = "0.1 ohm ± 20 %";
  return model;
}

// Some place in every part's range that is neither its middle nor an end.
std::vector<double> choose_values(const DeviceBox& box) {
  std::vector<double> values;
  for (const Tolerance& t : box.tolerances()) {
    const double part = 0.15 + 0.7 * std::fmod(0.37 * static_cast<double>(values.size() + 1), 1);
    values.push_back(t.low + part * (t.high - t.low));
  }
  return values;
}

double value_of(const DeviceBox& box, const std::vector<double>& values, const std::string& name) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (box.tolerances()[i].name == name) return values[i];
  ADD_FAILURE() << "no " << name;
  return 0;
}

// The model as a file with these values in it.
json write_values(json model, const DeviceBox& box, const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    model[json::json_pointer(box.tolerances()[i].pointer)] = values[i];
  return model;
}

// The two are built by the same steps from numbers that differ by rounding.
void expect_same_response(const Device& a, const Device& b, const std::string& what) {
  constexpr double rounding = 1e-9;
  const std::vector<double> frequency_hz{0.3, 12, 480, 20000};
  const auto first = compute_port_response(a, frequency_hz);
  const auto second = compute_port_response(b, frequency_hz);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const auto near = [&](std::complex<double> x, std::complex<double> y) {
      return std::abs(x - y) <= rounding * std::abs(x);
    };
    EXPECT_TRUE(near(first[i].impedance, second[i].impedance))
        << what << " at " << frequency_hz[i] << " Hz: " << first[i].impedance << " "
        << second[i].impedance;
    EXPECT_TRUE(near(first[i].actuation, second[i].actuation))
        << what << " at " << frequency_hz[i] << " Hz: " << first[i].actuation << " "
        << second[i].actuation;
  }
}

struct Kind {
  json damping;
  const char* amplifier = "current";
};

// Every kind whose parts can vary, each key of it with a tolerance; those whose settings come from
// the motor are below.
std::vector<Kind> list_kinds() {
  return {
      {nullptr},
      {nullptr, "ideal"},
      {nullptr, "voltage"},
      {{{"kind", "resistor"}, {"resistance", "5 ohm ± 1 %"}}},
      {{{"kind", "rc"}, {"resistance", "5 ohm ± 1 %"}, {"capacitance", "2200 uF +20 % -10 %"}}},
      {{{"kind", "clamp"}, {"voltage", "12 V"}}},
      {{{"kind", "netlist"}, {"file", "docs/drives/models/snubber.cir"}}},
      {{{"kind", "resistance_cancellation"},
        {"resistance", "1 ohm ± 2 %"},
        {"bandwidth", "10 kHz ± 20 %"}},
       "voltage"},
      {{{"kind", "back_emf"},
        {"damping", 0},
        {"resistance_estimate", "1.9 ohm ± 2 %"},
        {"inductance_estimate", "0.4 mH ± 2 %"},
        {"low_pass", "2 kHz ± 2 %"},
        {"high_pass", "1 Hz ± 2 %"}}},
      {{{"kind", "held_impedance"}, {"bandwidth", "10 kHz ± 20 %"}}},
      {{{"kind", "torque_sensed_damper"},
        {"damping", "1 mN.m.s/rad ± 10 %"},
        {"cutoff", "30 Hz ± 5 %"}}},
      {{{"kind", "eddy_current_brake"}, {"damping", "1 mN.m.s/rad ± 10 %"}}},
      {{{"kind", "high_pass_damper"},
        {"inertia", "10 g.cm^2 ± 5 %"},
        {"damping", "1 mN.m.s/rad ± 10 %"}}},
      {{{"kind", "friction_brake"}, {"damping", "1 mN.m.s/rad ± 10 %"}, {"effort", "1 N.m"}}},
  };
}

TEST(DeviceBox, is_the_device_of_a_file_with_those_values_at_the_nominal_gain) {
  for (const Kind& kind : list_kinds()) {
    const json document = make_model(kind.damping, kind.amplifier);
    const std::string what = document["damping"].dump() + kind.amplifier;
    const Model model = parse_model(document, "model.json");
    const DeviceBox box = model.device_box();
    const std::vector<double> values = choose_values(box);
    Device written = parse_model(write_values(document, box, values), "model.json").device;
    written.gain = find_amplifier_gain(model.device);
    expect_same_response(box.at(values), written, what);
    // Without it, the test would pass for a box that varies nothing.
    const Device varied = box.at(values);
    EXPECT_NE(varied.mechanics.inertia, model.device.mechanics.inertia);
    EXPECT_EQ(varied.mechanics.inertia, value_of(box, values, "mechanics.inertia"));
  }
}

TEST(DeviceBox, nominal_values_give_the_nominal_device) {
  for (const Kind& kind : list_kinds()) {
    const Model model = parse_model(make_model(kind.damping, kind.amplifier), "model.json");
    const DeviceBox box = model.device_box();
    expect_same_response(box.at(box.nominal_values()), model.device, kind.damping.dump());
  }
}

// Torque per command of a bare motor, its current set by a gain that was K_t0's.
TEST(DeviceBox, amplifier_gain_stays_so_that_a_stronger_motor_gives_more_effort) {
  const Model model = parse_model(make_model(nullptr), "m");
  const DeviceBox box = model.device_box();
  std::vector<double> values = box.nominal_values();
  values[0] *= 1.05;
  ASSERT_EQ(box.tolerances()[0].name, "motor.torque_constant");
  const Device strong = box.at(values);
  EXPECT_NEAR(std::abs(compute_port_response(strong, {1}).front().actuation), 1.05, 1e-9);
  EXPECT_NEAR(find_amplifier_gain(strong), 1 / 0.05, 1e-9);
}

TEST(DeviceBox, a_cancelled_fraction_is_one_of_the_nominal_winding) {
  const json document =
      make_model({{"kind", "resistance_cancellation"}, {"fraction", "0.8 ± 5 %"}}, "voltage");
  const Model model = parse_model(document, "m");
  const DeviceBox box = model.device_box();
  const std::vector<double> values = choose_values(box);
  json written = write_values(document, box, values);
  const double fraction = value_of(box, values, "resistance_cancellation.fraction");
  written["damping"][0] = {{"kind", "resistance_cancellation"}, {"resistance", fraction * 2.0}};
  Device expected = parse_model(written, "m").device;
  expected.gain = find_amplifier_gain(model.device);
  expect_same_response(box.at(values), expected, "fraction");
}

// command = -(d/K_t0) e: in the file of a motor with K_t, whose gain is d'/K_t, d' = d K_t/K_t0.
TEST(DeviceBox, back_emf_keeps_its_gain_and_its_estimates) {
  const json document =
      make_model({{"kind", "back_emf"}, {"damping", "0.1 mN.m.s/rad ± 10 %"}, {"low_pass", 1000}});
  const Model model = parse_model(document, "m");
  const DeviceBox box = model.device_box();
  const std::vector<double> values = choose_values(box);
  json written = write_values(document, box, values);
  const double K_t = value_of(box, values, "motor.torque_constant");
  written["damping"][0]["damping"] = value_of(box, values, "back_emf.damping") * K_t / 0.05;
  written["damping"][0]["resistance_estimate"] = "2 ohm";
  written["damping"][0]["inductance_estimate"] = "0.5 mH";
  Device expected = parse_model(written, "m").device;
  expected.gain = find_amplifier_gain(model.device);
  expect_same_response(box.at(values), expected, "back_emf");
}

// The resistor is K_t0^2/b_w - R_out0; the port sees the motor behind it, its winding and the
// amplifier, and no K_t but its own.
TEST(DeviceBox, a_wave_drive_keeps_its_resistor) {
  const json document =
      make_model({{"kind", "wave"}, {"impedance", "1 mN.m.s/rad ± 5 %"}}, "voltage");
  const Model model = parse_model(document, "m");
  const DeviceBox box = model.device_box();
  const std::vector<double> values = choose_values(box);
  const auto part = [&](const char* name) { return value_of(box, values, name); };
  const double resistor = 0.05 * 0.05 / part("wave.impedance") - 0.1;
  const double winding = part("motor.resistance") *
                         (1 + copper_temperature_coefficient * part("motor.temperature_rise"));
  const std::complex<double> s(0, 2 * std::acos(-1.0) * 40);
  const double K_t = part("motor.torque_constant");
  const std::complex<double> expected =
      part("mechanics.inertia") * s + part("mechanics.damping") +
      K_t * K_t /
          (resistor + part("amplifier.output_resistance") + winding + part("motor.inductance") * s);
  const auto found = compute_port_response(box.at(values), {40}).front().impedance;
  EXPECT_LT(std::abs(found - expected), 1e-9 * std::abs(expected)) << found << " " << expected;
}

TEST(DeviceBox, parts_are_named_by_what_they_are) {
  json document = make_model({{"kind", "resistor"}, {"resistance", "5 ohm ± 1 %"}});
  document["damping"].push_back(
      {{"kind", "rc"}, {"resistance", 1}, {"capacitance", "1 mF ± 20 %"}});
  document["damping"].push_back({{"kind", "resistor"}, {"resistance", "50 ohm ± 1 %"}});
  std::vector<std::string> names;
  const Model model = parse_model(document, "m");
  for (const Tolerance& t : model.parts.tolerances) names.push_back(t.name);
  EXPECT_EQ(names, (std::vector<std::string>{
                       "motor.torque_constant", "motor.resistance", "motor.inductance",
                       "motor.temperature_rise", "mechanics.inertia", "mechanics.damping",
                       "resistor.resistance", "rc.capacitance", "resistor_2.resistance"}));
}

std::string find_refusal(const json& document) {
  try {
    parse_model(document, "m");
  } catch (const Error& error) {
    return error.place() + ": " + error.message();
  }
  return "no error";
}

TEST(ModelTolerances, ends_at_which_there_is_no_device_are_refused) {
  json document = make_model(nullptr);
  document["motor"]["temperature_rise"] = "0 K (-300 K to 40 K)";
  const std::string cold = find_refusal(document);
  EXPECT_NE(cold.find("m: /motor/temperature_rise: "), std::string::npos) << cold;
  EXPECT_NE(cold.find("above -254.45"), std::string::npos) << cold;
  // 0.05^2/b_w is less than the 0.1 ohm that the amplifier has.
  document = make_model({{"kind", "wave"}, {"impedance", "20 mN.m.s/rad ± 50 %"}}, "voltage");
  const std::string wave = find_refusal(document);
  EXPECT_NE(wave.find("m: /damping/0/impedance: "), std::string::npos) << wave;
  EXPECT_NE(wave.find("at its high end 30 mN.m.s/rad"), std::string::npos) << wave;
}

TEST(ModelTolerances, what_the_linear_analyses_leave_out_and_the_controller_have_none) {
  for (const char* pointer : {"/mechanics/coulomb_friction", "/amplifier/voltage_limit",
                              "/controller/stiffness", "/sampling/period"}) {
    json document = make_model(nullptr);
    document[json::json_pointer(pointer)] = "1 ± 5 %";
    EXPECT_NE(find_refusal(document).find("no tolerance is possible here"), std::string::npos)
        << pointer << ": " << find_refusal(document);
  }
}

}  // namespace
}  // namespace gyrator
