#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

// Small results in the commands' shapes; the numbers are made up but plausible.

inline nlohmann::json sample_base(const std::string& command) {
  return {{"command", command},
          {"program", "gyrator 1.2.3"},
          {"model_name", "RC-damped display"},
          {"model", {{"schema", "gyrator/model/1"}, {"name", "RC-damped display"}}},
          {"command_line", "gyrator " + command + " device.json --json"},
          {"units",
           {{"damping", "N.m.s/rad"},
            {"stiffness", "N.m/rad"},
            {"position", "rad"},
            {"velocity", "rad/s"},
            {"effort", "N.m"}}}};
}

inline nlohmann::json sample_criterion(const std::string& name, bool holds, double limit) {
  return {{"name", name},
          {"applies", name == "exact_disk"},
          {"holds", holds},
          {"margin", holds ? 2e-5 : -3e-5},
          {"worst_frequency_hz", 13.1},
          {"max_stiffness", limit},
          {"reason", "reason of " + name}};
}

/// At K = 0.4 the textbook (limit 0.5) and the exact disk (limit 0.0658) disagree.
inline nlohmann::json sample_passivity() {
  auto result = sample_base("passivity");
  std::vector<double> time;
  std::vector<double> position;
  for (int i = 0; i < 200; ++i) {
    time.push_back(0.01 * i);
    position.push_back(0.01 * std::exp(0.02 * i) * std::sin(0.3 * i));
  }
  result["verdict"] = "not_passive";
  result["stiffness"] = 0.4;
  result["virtual_damping"] = 1.5e-4;
  result["criteria"] = {sample_criterion("frequency_dependent", true, 0.5),
                        sample_criterion("exact_disk", false, 0.0658)};
  result["damping_over_frequency"] = {{"frequency_hz", {1, 10, 100, 499}},
                                      {"physical", {1e-4, 2e-4, 4e-4, 4e-4}},
                                      {"virtual", {-5e-5, -5e-5, -8e-5, -3e-4}},
                                      {"total", {5e-5, 1.5e-4, 3.2e-4, 1e-4}},
                                      {"exact", {-1e-6, nullptr, 3e-4, 9e-5}}};
  result["disk"] = {{"frequency_hz", 13.1}, {"center_real", -2.9},   {"center_imag", -16.2},
                    {"radius", 16.4},       {"critical_real", -2.5}, {"critical_imag", 0.08}};
  result["counterexample"] = {{"inertia", 3.6e-3},
                              {"stiffness", 0},
                              {"resonators", nlohmann::json::array()},
                              {"spectral_radius", 1.0087},
                              {"frequency_hz", 1.7},
                              {"simulation",
                               {{"classification", "diverges"},
                                {"time_s", time},
                                {"position", position},
                                {"command", position}}}};
  return result;
}

inline nlohmann::json sample_zwidth() {
  auto result = sample_base("zwidth");
  const std::vector<double> damping = {0, 1e-4, 2e-4};
  result["boundaries"] = {
      {{"criterion", "spring_damper"}, {"damping", damping}, {"max_stiffness", {0.2, 0, 0}}},
      {{"criterion", "frequency_dependent"},
       {"damping", damping},
       {"max_stiffness", {0.55, 0.52, 0.49}}},
      {{"criterion", "exact_disk"}, {"damping", damping}, {"max_stiffness", {0.02, 0.06, 0.07}}}};
  result["point"] = {{"damping", 1.5e-4}, {"stiffness", 0.4}};
  return result;
}

inline nlohmann::json sample_simulate() {
  auto result = sample_base("simulate");
  result["classification"] = "settles";
  result["final_time_s"] = 0.5;
  result["steps"] = 500;
  result["trace"] = {{"time_s", {0, 0.1, 0.2}},       {"position", {0, 0.01, -0.005}},
                     {"velocity", {1, 0.5, -0.2}},    {"effort", {0, 0, 0}},
                     {"command", {0, -0.004, 0.002}}, {"current", {0, -0.1, 0.05}}};
  result["energy"] = {{"operator", 0.0},
                      {"source", -1.5e-6},
                      {"stored", -9e-6},
                      {"dissipated", 7.5e-6},
                      {"residual", 4.25e-18}};
  return result;
}

inline nlohmann::json sample_impedance() {
  auto result = sample_base("impedance");
  result["frequency_hz"] = {1, 10, 100};
  result["impedance_real"] = {1e-4, -2e-4, 3e-4};
  result["impedance_imag"] = {1e-4, 1e-3, 1e-2};
  result["actuation_real"] = {1, 0.9, 0.5};
  result["actuation_imag"] = {0, -0.1, -0.5};
  return result;
}

/// Two designs, the second of which oscillates when its winding cools.
inline nlohmann::json sample_compare() {
  auto result = sample_base("compare");
  const auto design = [](const std::string& name, double scale, bool stable) {
    const nlohmann::json warmer = {{"stable", true}, {"max_stiffness", 0.5 * scale}};
    return nlohmann::json{{"name", name},
                          {"damping", {0, 1e-4, 2e-4}},
                          {"max_stiffness", {0.7 * scale, scale, 0}},
                          {"best", {{"damping", 1e-4}, {"max_stiffness", scale}}},
                          {"damping_1hz", 1e-4},
                          {"damping_100hz", 3e-4},
                          {"apparent_inertia", 2e-5},
                          {"colder", {{"stable", stable}, {"max_stiffness", nullptr}}},
                          {"warmer", warmer}};
  };
  result["temperature_step"] = 25;
  result["designs"] = {design("plain", 0.01, true), design("cancelled", 2, false)};
  return result;
}

inline nlohmann::json sample_design() {
  auto result = sample_base("design");
  const nlohmann::json point{{"apparent_inertia", 1e-7}, {"max_stiffness", 0.11}};
  result["feasible"] = true;
  result["virtual_damping"] = {1e-4};
  result["fronts"] = {{{"topology", "rc"}, {"points", {point}}}};
  result["designs"] = {{{"topology", "rc"},
                        {"values", {{"rc.resistance", 2.4}, {"digital.pre_emphasis", true}}},
                        {"max_stiffness", 0.11},
                        {"rated_stiffness", 0.099},
                        {"apparent_inertia", 1e-7},
                        {"yield", 0.82},
                        {"constraints",
                         {{{"name", "apparent_inertia"},
                           {"side", "max"},
                           {"unit", "kg.m^2"},
                           {"value", 1e-7},
                           {"limit", 2e-7}}}},
                        {"bill_of_materials",
                         {{{"name", "rc.resistance"},
                           {"part", "resistor"},
                           {"count", 1},
                           {"written", "2.4 ohm"},
                           {"tolerance", 0.01}}}},
                        {"boundary", {{"damping", {0, 1e-4}}, {"max_stiffness", {0.001, 0.11}}}},
                        {"loses_because", nullptr}}};
  return result;
}

/// Two renderings, one of which breaks the third condition.
inline nlohmann::json sample_two_port() {
  auto result = sample_base("twoport");
  const auto part = [](const char* name, bool stable) {
    const auto condition = [](const char* text, bool holds) {
      return nlohmann::json{{"condition", text},
                            {"holds", holds},
                            {"margin", holds ? 0.01 : -0.7},
                            {"worst_frequency_hz", 15},
                            {"violated_hz", nlohmann::json::array()}};
    };
    nlohmann::json value{
        {"rendering", name},
        {"absolutely_stable", stable},
        {"frequency_hz", {0.1, 1, 10}},
        {"h11_real", {0.01, 0.01, 0.02}},
        {"h22_real", {1e-6, 1e-4, 0.01}},
        {"margin", {0, stable ? 0.1 : -0.1, stable ? 2.0 : -0.7}},
        {"transmitted_real", {0.1, 0.2, 0.3}},
        {"transmitted_imag", {0.1, 0.2, 0.3}},
        {"transparency", {0.5, nullptr, 0.1}},
        {"conditions", {condition("Re h11 >= 0", true), condition("third", stable)}}};
    if (!stable) value["conditions"][1]["violated_hz"].push_back({0, 15});
    return value;
  };
  result.update(part("direct", false));
  result["renderings"] = {part("direct", false), part("equivalent_impedance", true)};
  return result;
}

/// A plane of two by two points, one of each region.
inline nlohmann::json sample_stability_map() {
  auto result = sample_base("stability-map");
  result["beta"] = {0.25, 0.75};
  result["sigma"] = {0.25, 0.75};
  const auto row = [](const char* left, const char* right) {
    return nlohmann::json::array({left, right});
  };
  result["region"] =
      nlohmann::json::array({row("unstable", "limit_cycle"), row("locally_stable", "passive")});
  result["analytic_region"] =
      nlohmann::json::array({row("unstable", "limit_cycle"), row("unstable", "passive")});
  result["delay_in_periods"] = 0;
  result["small_velocity"] = 0.25;
  result["large_velocity"] = 4;
  result["passive_points_that_do_not_rest"] = 0;
  result["other_points_that_rest"] = 0;
  return result;
}

/// Two parts, one of which has no bounded limit at its high end.
inline nlohmann::json sample_tolerance() {
  auto result = sample_base("tolerance");
  result["robust"] = false;
  result["stiffness"] = 0.055;
  result["virtual_damping"] = 1.5e-4;
  result["nominal"] = {{"max_stiffness", 0.0658}, {"passive", true}, {"margin", 4e-5}};
  result["worst"] = {{"max_stiffness", 0.04}, {"passive", false}, {"margin", -6e-5}};
  result["parts"] = {{{"name", "rc.capacitance"},
                      {"unit", "F"},
                      {"written", "2200 uF ± 20 %"},
                      {"worst", 2640e-6},
                      {"max_stiffness_at_low", 0.079},
                      {"max_stiffness_at_high", 0.056},
                      {"sensitivity", -0.17},
                      {"rank_correlation", -0.6}},
                     {{"name", "mechanics.damping"},
                      {"unit", "N.m.s/rad"},
                      {"written", "1e-4 N.m.s/rad ± 30 %"},
                      {"worst", 7e-5},
                      {"max_stiffness_at_low", 0.06},
                      {"max_stiffness_at_high", nullptr},
                      {"sensitivity", nullptr},
                      {"rank_correlation", 0.4}}};
  result["samples"] = {{"count", 1000},
                       {"yield", 0.9},
                       {"yield_low", 0.88},
                       {"yield_high", 0.917},
                       {"histogram", {{"edges", {0.045, 0.06, 0.08}}, {"count", {300, 700}}}}};
  return result;
}

/// Three frequencies; the last has walls without bound.
inline nlohmann::json sample_envelope() {
  auto result = sample_base("zwidth-envelope");
  result["criterion"] = "exact_disk";
  result["frequency_hz"] = {1, 10, 100};
  result["impedance_max"] = {0.03, 0.002, nullptr};
  result["impedance_min"] = {3e-6, 3e-4, 0.012};
  result["admittance_max"] = {3e5, 3e3, 80};
  result["admittance_min"] = {30, 500, 0};
  result["bare_impedance"] = {2e-4, 1.5e-3, 0.0125};
  result["areas"] = {{"logarithmic", 2.5}, {"impedance", 0.01}, {"admittance", 6e4}};
  return result;
}

/// A step that falls again, on a device whose command takes another path.
inline nlohmann::json sample_environment() {
  auto result = sample_base("environment");
  result["verdict"] = "not_passive";
  result["applies"] = false;
  result["reasons"] = {"the sensor is not at the port"};
  result["alpha"] = 1e-4;
  result["delta"] = 2e-4;
  result["allowed_alpha"] = 2e-4;
  result["coupling_damping"] = nullptr;
  result["steepest_rise"] = {{"slope", 0.2}, {"from", 0}, {"to", 0.1}};
  result["steepest_fall"] = nullptr;
  result["profile"] = {
      {"file", "step.csv"}, {"position", {0, 0.1, 0.2}}, {"effort", {0, 0.02, 0.02}}};
  return result;
}

/// Two poses, one of which does not suffice.
inline nlohmann::json sample_workspace() {
  auto result = sample_base("workspace");
  const auto pose = [](const char* name, double isotropic, double factor) {
    return nlohmann::json{{"name", name},
                          {"largest_isotropic", isotropic},
                          {"least_eigenvalue", 0.01 * (factor - 1)},
                          {"allowed_factor", factor},
                          {"holds", factor >= 1}};
  };
  result["poses"] = {pose("near", 0.5, 1.6), pose("far", 0.2, 0.7)};
  result["verdict"] = "not_enough";
  result["allowed_factor"] = 0.7;
  result["worst_pose"] = "far";
  return result;
}

/// Nine parameters less one that could not be found, three sines and four stretches of motion.
inline nlohmann::json sample_identification() {
  auto result = sample_base("identify");
  result["outcome"] = "identified";
  result["duration_s"] = 21.5;
  result["parameters"] = {{{"name", "resistance"},
                           {"value", 1.5},
                           {"low", 1.49},
                           {"high", 1.51},
                           {"unit", "ohm"},
                           {"identifiable", true},
                           {"note", "at 298.15 K"}},
                          {{"name", "bandwidth"},
                           {"value", nullptr},
                           {"low", nullptr},
                           {"high", nullptr},
                           {"unit", "Hz"},
                           {"identifiable", false},
                           {"note", "no command"}}};
  const nlohmann::json real{1.5, 1.51, 1.52}, imag{0.1, 1.0, 3.1};
  result["sines"] = {{"frequency_hz", {40, 300, 1000}}, {"amplitude", {0.5, 0.5, 0.5}}};
  for (const char* name : {"impedance", "fitted_impedance", "current", "fitted_current"}) {
    result["sines"][std::string(name) + "_real"] = real;
    result["sines"][std::string(name) + "_imag"] = imag;
  }
  result["friction"] = {{"velocity", {-100, -20, 20, 100}},
                        {"effort", {-0.002, -0.0012, 0.0012, 0.002}},
                        {"damping", 1e-5},
                        {"coulomb_friction", 1e-3}};
  return result;
}

/// A tuning of one step.
inline nlohmann::json sample_tuning() {
  auto result = sample_base("tune");
  result["outcome"] = "reached";
  result["verdict"] = "passive";
  result["settings"] = {{"damping_resistance", 5.0}};
  result["steps"] = {{{"time_s", 1.0},
                      {"settings", {{"damping_resistance", 5.0}}},
                      {"winding_resistance", 1.6},
                      {"measured_damping", 3.7e-4},
                      {"modelled_damping", 3.8e-4},
                      {"frequency_hz", 20.0},
                      {"stable", true},
                      {"remark", ""}}};
  return result;
}

}  // namespace gyrator
