// Maps by co-simulation against the exact loop's eigenvalues, the reference engine, and what has
// been published of Z-width.

#include "gyrator/core/random_stream.hpp"
#include "gyrator/cosim/simulation.hpp"
#include "gyrator/studies/results.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

json make_document() {
  return {{"schema", "gyrator/model/1"},
          {"name", "display"},
          {"motion", "rotary"},
          {"motor", {{"torque_constant", 0.05}, {"resistance", 1.5}, {"inductance", 0.5e-3}}},
          {"mechanics", {{"inertia", 2e-5}, {"damping", 1e-4}}},
          {"amplifier", {{"kind", "current"}}},
          {"damping", json::array({{{"kind", "rc"}, {"resistance", 5}, {"capacitance", 2200e-6}}})},
          {"sampling", {{"period", "1 ms"}}},
          {"controller", {{"kind", "virtual_wall"}, {"stiffness", 0.1}, {"damping", 1e-4}}},
          {"simulation", {{"duration", "2 s"}, {"initial_velocity", 1.0}}}};
}

std::vector<double> spread(double from, double to, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(from + (to - from) * i / (count - 1));
  return values;
}

json make_map(const json& document, const std::vector<double>& damping,
              const std::vector<double>& stiffness) {
  const Model model = parse_model(document, "test.json");
  TimeMapRequest request;
  request.damping = damping;
  request.stiffness = stiffness;
  return make_time_boundary(model, request);
}

TEST(TimeMap, has_the_border_of_the_exact_loops_eigenvalues) {
  const auto damping = spread(0, 6e-4, 13);
  const auto stiffness = spread(0.02, 1.5, 75);
  const json map = make_map(make_document(), damping, stiffness);
  EXPECT_EQ(map["map"]["computed_by"], "lanes");
  const Model model = parse_model(make_document(), "test.json");
  StiffnessLimits limits(model.device, model.sampling, model.controller, model.held_by);
  const double cell = stiffness[1] - stiffness[0];
  for (std::size_t j = 0; j < damping.size(); ++j) {
    const double exact = limits.find(Criterion::coupled, damping[j]).stiffness;
    EXPECT_NEAR(map["max_stiffness"][j].get<double>(), exact, cell) << damping[j];
  }
}

TEST(TimeMap, tells_of_each_cell_what_the_reference_engine_tells) {
  json document = make_document();
  document["sensor"] = {{"quantum", 2e-4}};
  document["controller"]["unilateral"] = true;
  document["operator"] = {{"kind", "mass_spring_damper"}, {"stiffness", 0.02}, {"damping", 2e-5}};
  document["simulation"]["duration"] = "0.5 s";
  document["simulation"]["external_effort"] = 1e-3;
  const auto damping = spread(0, 6e-4, 16);
  const auto stiffness = spread(0.05, 1.5, 16);
  const json map = make_map(document, damping, stiffness);
  const Model model = parse_model(document, "test.json");
  const Plant plant = build_moving_plant(build_device_network(model.device, model.held_by));
  RandomStream random(7, 0);
  std::vector<int> counts(3);
  for (int n = 0; n < 200; ++n) {
    const auto i = static_cast<std::size_t>(random.uniform() * 16);
    const auto j = static_cast<std::size_t>(random.uniform() * 16);
    Controller controller = model.controller;
    std::get<VirtualWall>(controller.law).stiffness = stiffness[i];
    std::get<VirtualWall>(controller.law).damping = damping[j];
    SimulationOptions options;
    options.duration = model.duration;
    options.initial_velocity = model.initial_velocity;
    options.external_effort = model.external_effort;
    options.engine = EngineKind::cvode;
    options.engine_options.ledger = false;
    const Classification run =
        simulate(plant, model.sensor, controller, model.sampling, options).classification;
    const int found = map["map"]["outcome"][i][j];
    EXPECT_EQ(found, static_cast<int>(run.outcome)) << stiffness[i] << ' ' << damping[j];
    ++counts[static_cast<std::size_t>(found)];
  }
  for (const int count : counts) EXPECT_GT(count, 0);
}

TEST(TimeMap, of_a_device_with_friction_is_run_cell_by_cell) {
  json document = make_document();
  document["mechanics"]["coulomb_friction"] = 1e-4;
  document["simulation"]["duration"] = "0.2 s";
  const json map = make_map(document, {1e-4}, {0.01, 1.5});
  EXPECT_NE(map["map"]["computed_by"].get<std::string>().find("friction"), std::string::npos)
      << map["map"]["computed_by"];
  EXPECT_EQ(map["map"]["outcome"][0][0], 0);
  EXPECT_EQ(map["map"]["outcome"][1][0], 2);
}

// A bare mass with a little damping, the display of the Z-width literature.
json make_mass(double damping, double period, double quantum) {
  json document = make_document();
  document.erase("motor");
  document.erase("damping");
  document["amplifier"] = {{"kind", "ideal"}};
  document["mechanics"]["damping"] = damping;
  document["sampling"]["period"] = period;
  document["sensor"] = {{"quantum", quantum}};
  return document;
}

// What the map says of a mass over B from 0 to 0.08 and K to 40.
struct Width {
  double stiffness = 0;  ///< largest K over all B
  double damping = 0;    ///< largest B at which the softest wall settles
  double rumbling = 0;   ///< share of cells with a limit cycle
};
Width find_width(const json& document) {
  const auto damping = spread(0, 0.08, 17);
  const json map = make_map(document, damping, spread(1, 40, 40));
  Width width;
  for (std::size_t j = 0; j < damping.size(); ++j) {
    const json& K = map["max_stiffness"][j];
    width.stiffness = std::max(width.stiffness, K.is_null() ? 40 : K.get<double>());
    if (map["map"]["outcome"][0][j] == 0) width.damping = damping[j];
  }
  for (const auto& row : map["map"]["outcome"])
    width.rumbling += static_cast<double>(std::count(row.begin(), row.end(), 1)) / (17 * 40);
  return width;
}

TEST(TimeMap, grows_with_the_sampling_rate) {
  const Width slow = find_width(make_mass(1e-3, 1e-3, 0));
  const Width fast = find_width(make_mass(1e-3, 0.5e-3, 0));
  // A bilateral wall on a mass: B < b + m/T, and K as B/T.
  EXPECT_GT(fast.stiffness, 2 * slow.stiffness);
  EXPECT_GT(fast.damping, 1.5 * slow.damping);
}

TEST(TimeMap, grows_both_ways_with_physical_damping) {
  const Width light = find_width(make_mass(1e-4, 1e-3, 0));
  const Width heavy = find_width(make_mass(1e-2, 1e-3, 0));
  EXPECT_GT(heavy.stiffness, 1.5 * light.stiffness);
  EXPECT_GT(heavy.damping, light.damping);
}

TEST(TimeMap, shows_coarse_encoders_rumble) {
  const Width fine = find_width(make_mass(1e-3, 1e-3, 0));
  const Width coarse = find_width(make_mass(1e-3, 1e-3, 1e-3));
  EXPECT_LT(fine.rumbling, 0.01);
  EXPECT_GT(coarse.rumbling, 0.05);
  // Sampled faster, a velocity of one step is larger: there is more of it.
  EXPECT_GT(find_width(make_mass(1e-3, 0.25e-3, 1e-3)).rumbling, 3 * coarse.rumbling);
}

// Levels and corner of fig. 8.26; the motor is not given there. Without virtual damping the branch
// costs stiffness (it delays the command), with it the boundary rises from level to level.
TEST(TimeMap, rises_with_the_level_of_electrical_damping) {
  constexpr double pi = 3.14159265358979;
  const std::vector<double> damping{0.025, 0.05, 0.075};
  std::vector<double> before(damping.size(), 0);
  for (const double level : {0.0, 0.00755, 0.0151}) {
    json document = make_document();
    document["motor"] = {{"torque_constant", 0.5}, {"resistance", 2}, {"inductance", 1e-3}};
    document["mechanics"] = {{"inertia", 5e-4}, {"damping", 2e-3}};
    document.erase("damping");
    if (level > 0) {
      const double R = 0.25 / level;  // K_t^2 / level, winding included
      document["damping"] = json::array(
          {{{"kind", "rc"}, {"resistance", R - 2}, {"capacitance", 1 / (2 * pi * 2.6 * R)}}});
    }
    document["sensor"] = {{"quantum", 1e-4}};
    document["controller"]["unilateral"] = true;
    document["operator"] = {{"kind", "mass_spring_damper"}, {"stiffness", 0.5}, {"damping", 1e-3}};
    const json map = make_map(document, damping, spread(2, 100, 50));
    for (std::size_t j = 0; j < damping.size(); ++j) {
      const double K = map["max_stiffness"][j];
      if (level > 0) {
        EXPECT_GT(K, before[j]) << level << ' ' << damping[j];
      }
      before[j] = K;
    }
  }
}

}  // namespace
}  // namespace gyrator
