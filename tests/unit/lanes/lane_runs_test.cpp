#include "gyrator/lanes/lane_runs.hpp"

#include "gyrator/mechanics/device.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

// Every instruction set that this machine can run.
std::vector<LaneInstructions> list_instructions() {
  std::vector<LaneInstructions> list{LaneInstructions::baseline};
  const LaneInstructions widest = find_lane_instructions();
  if (widest >= LaneInstructions::avx2) list.push_back(LaneInstructions::avx2);
  if (widest >= LaneInstructions::avx512) list.push_back(LaneInstructions::avx512);
  return list;
}

Device make_rc_display() {
  return passivity_tests::make_rc_motor().device;
}

LaneScene make_scene() {
  LaneScene scene;
  scene.sampling = {Rational(1, 1000), Rational(0)};
  scene.options.duration = Rational(3, 10);
  scene.options.initial_position = -0.01;
  scene.options.initial_velocity = 1;
  scene.options.engine_options.ledger = false;
  return scene;
}

struct Case {
  std::string name;
  Device device;
  Operator held_by;
  LaneScene scene;
  VirtualWall wall;
};

std::vector<Case> make_cases() {
  std::vector<Case> cases;
  const VirtualWall wall{.stiffness = 0.3, .damping = 1.5e-4};
  const auto add = [&](const char* name, auto&& change) {
    Case c{name, make_rc_display(), FreeOperator{}, make_scene(), wall};
    change(c);
    cases.push_back(c);
  };
  add("linear", [](Case&) {});
  add("unilateral", [](Case& c) { c.wall.unilateral = true; });
  add("may not pull", [](Case& c) { c.wall.unilateral = c.wall.no_pull = true; });
  add("held by a hand", [](Case& c) {
    c.held_by =
        MassSpringDamper{.inertia = 1e-5, .damping = 1e-3, .stiffness = 0.5, .resonators = {}};
  });
  add("late by half a period", [](Case& c) { c.scene.sampling.delay = Rational(1, 2000); });
  add("late by two periods", [](Case& c) { c.scene.sampling.delay = Rational(1, 500); });
  add("late by 1.3 periods", [](Case& c) { c.scene.sampling.delay = Rational(13, 10000); });
  add("difference over 3", [](Case& c) { c.wall.velocity = DifferenceEstimator{3}; });
  add("Butterworth", [](Case& c) { c.wall.velocity = ButterworthEstimator{2, 100}; });
  add("limited command", [](Case& c) { c.scene.options.dac.limit = 1e-3; });
  add("pushed", [](Case& c) {
    c.scene.options.external_effort = 1e-3;
    c.scene.options.gesture = HandGesture{HitGesture{0.02, 0.01, {0.05}}};
  });
  add("offset sensor", [](Case& c) { c.scene.sensor.offset = 1e-3; });
  add("noisy sensor", [](Case& c) { c.scene.sensor.noise = 1e-4; });
  add("no circuit", [](Case& c) { c.device.drive.damping.clear(); });
  return cases;
}

TimeRun run_engine(const Case& c, const Plant& plant) {
  return simulate(plant, c.scene.sensor, Controller(c.wall), c.scene.sampling, c.scene.options);
}

LaneTrace run_lane(const Case& c, const Plant& plant, LaneInstructions instructions) {
  const LanePlant lane_plant = make_lane_plant(plant, c.scene.sampling);
  const auto law = find_lane_law(Controller(c.wall), c.scene.sampling.period.to_double());
  EXPECT_TRUE(law) << c.name;
  LaneOptions options;
  options.instructions = instructions;
  return trace_lanes(c.scene, {{&lane_plant, *law}}, options).front();
}

double largest(const std::vector<double>& values) {
  double size = 0;
  for (const double value : values) size = std::max(size, std::abs(value));
  return size;
}

TEST(Lanes, move_as_the_exact_engine_moves) {
  // Another order of a few hundred sums over 300 samples of a stable loop.
  constexpr double rounding = 1e-12;
  for (const Case& c : make_cases()) {
    const Plant plant = build_plant(build_device_network(c.device, c.held_by));
    ASSERT_EQ(find_lane_obstacle(plant, Controller(c.wall), c.scene), "") << c.name;
    const TimeRun run = run_engine(c, plant);
    const auto& position = run.trace.column("position");
    const auto& velocity = run.trace.column("velocity");
    for (const LaneInstructions instructions : list_instructions()) {
      const LaneTrace lane = run_lane(c, plant, instructions);
      ASSERT_EQ(lane.position.size(), position.size()) << c.name;
      for (std::size_t k = 0; k < position.size(); ++k) {
        ASSERT_NEAR(lane.position[k], position[k], rounding * largest(position))
            << c.name << ' ' << name_of(instructions) << ' ' << k;
        ASSERT_NEAR(lane.velocity[k], velocity[k], rounding * largest(velocity))
            << c.name << ' ' << name_of(instructions) << ' ' << k;
      }
    }
  }
}

TEST(Lanes, without_fused_products_move_as_the_exact_engine_to_the_last_bit) {
  // A spring alone: its law is one product in both.
  Case c{"spring", make_rc_display(), FreeOperator{}, make_scene(), {.stiffness = 0.3}};
  c.wall.unilateral = true;
  c.scene.sensor.quantum = 1e-4;
  const Plant plant = build_plant(build_device_network(c.device, c.held_by));
  const TimeRun run = run_engine(c, plant);
  const LaneTrace lane = run_lane(c, plant, LaneInstructions::baseline);
  EXPECT_EQ(lane.position, run.trace.column("position"));
  EXPECT_EQ(lane.velocity, run.trace.column("velocity"));
}

TEST(Lanes, quantize_position_and_command_as_the_engine_does) {
  for (const bool command : {false, true}) {
    Case c{"quantized", make_rc_display(), FreeOperator{}, make_scene(), {0.3, 1e-4}};
    c.wall.unilateral = true;
    c.scene.sensor.quantum = 1e-4;
    if (command) c.scene.options.dac.quantum = 1e-5;
    const Plant plant = build_plant(build_device_network(c.device, c.held_by));
    const TimeRun run = run_engine(c, plant);
    const auto& position = run.trace.column("position");
    for (const LaneInstructions instructions : list_instructions()) {
      const LaneTrace lane = run_lane(c, plant, instructions);
      // Until rounding first tips a sample over the edge between two quanta: never here.
      for (std::size_t k = 0; k < position.size(); ++k)
        ASSERT_NEAR(lane.position[k], position[k], 1e-11 * largest(position)) << k;
    }
  }
}

// Walls of a grid over the stable limit and above it, unilateral, with an encoder.
std::vector<VirtualWall> make_walls() {
  std::vector<VirtualWall> walls;
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j < 7; ++j)
      walls.push_back({.stiffness = 0.02 + 0.1 * i, .damping = 1e-4 * j, .unilateral = true});
  }
  return walls;
}

TEST(Lanes, are_classified_as_their_runs_are) {
  for (const double quantum : {0.0, 2e-4}) {
    LaneScene scene = make_scene();
    scene.sensor.quantum = quantum;
    const Operator hand =
        MassSpringDamper{.inertia = 1e-5, .damping = 2e-4, .stiffness = 0.5, .resonators = {}};
    const Plant plant = build_plant(build_device_network(make_rc_display(), hand));
    const LanePlant lane_plant = make_lane_plant(plant, scene.sampling);
    const std::vector<VirtualWall> walls = make_walls();
    const auto found = classify_lanes(scene, walls.size(), [&](std::size_t i, LaneDesign& design) {
      design = {&lane_plant, *find_lane_law(Controller(walls[i]), 1e-3)};
    });
    for (std::size_t i = 0; i < walls.size(); ++i) {
      const Classification run =
          simulate(plant, scene.sensor, Controller(walls[i]), scene.sampling, scene.options)
              .classification;
      EXPECT_EQ(found[i].outcome, run.outcome) << walls[i].stiffness << ' ' << walls[i].damping;
      if (run.outcome != Outcome::limit_cycle) continue;
      EXPECT_NEAR(found[i].amplitude, run.amplitude, 1e-6 * run.amplitude);
      EXPECT_NEAR(found[i].frequency_hz, run.frequency_hz, 1e-6 * run.frequency_hz);
    }
  }
}

TEST(Lanes, are_classified_by_the_cycles_of_their_traces_to_the_last_bit) {
  LaneScene scene = make_scene();
  scene.sensor.quantum = 2e-4;
  const Operator hand =
      MassSpringDamper{.inertia = 1e-5, .damping = 2e-4, .stiffness = 0.5, .resonators = {}};
  const Plant plant = build_plant(build_device_network(make_rc_display(), hand));
  const LanePlant lane_plant = make_lane_plant(plant, scene.sampling);
  std::vector<LaneDesign> designs;
  for (const VirtualWall& wall : make_walls())
    designs.push_back({&lane_plant, *find_lane_law(Controller(wall), 1e-3)});
  for (const LaneInstructions instructions : list_instructions()) {
    LaneOptions options;
    options.instructions = instructions;
    const auto traces = trace_lanes(scene, designs, options);
    const auto found = classify_lanes(
        scene, designs.size(), [&](std::size_t i, LaneDesign& design) { design = designs[i]; },
        options);
    int compared = 0;
    for (std::size_t i = 0; i < designs.size(); ++i) {
      if (traces[i].stopped_early || found[i].amplitude == 0) continue;  // not looked at closely
      const auto& [position, velocity, stopped] = traces[i];
      const Classification whole = classify(position, velocity, 1e-3, false);
      EXPECT_EQ(found[i].outcome, whole.outcome) << i;
      EXPECT_EQ(found[i].growth, whole.growth) << i;
      EXPECT_EQ(found[i].amplitude, whole.amplitude) << i;
      EXPECT_EQ(found[i].frequency_hz, whole.frequency_hz) << i;
      ++compared;
    }
    EXPECT_GT(compared, 20) << name_of(instructions);
  }
}

TEST(Lanes, of_plants_of_their_own_move_as_if_alone) {
  const LaneScene scene = make_scene();
  std::vector<LanePlant> plants;
  std::vector<LaneDesign> designs;
  for (int i = 0; i < 20; ++i) {
    Device device = make_rc_display();
    device.mechanics.inertia *= 1 + 0.1 * i;
    plants.push_back(
        make_lane_plant(build_plant(build_device_network(device, FreeOperator{})), scene.sampling));
  }
  for (const LanePlant& plant : plants)
    designs.push_back({&plant, *find_lane_law(Controller(VirtualWall{0.3, 1e-4}), 1e-3)});
  const auto together = trace_lanes(scene, designs);
  ASSERT_EQ(together.size(), designs.size());
  for (std::size_t i = 0; i < designs.size(); ++i) {
    const LaneTrace alone = trace_lanes(scene, {designs[i]}).front();
    for (std::size_t k = 0; k < alone.position.size(); ++k)
      ASSERT_NEAR(together[i].position[k], alone.position[k], 1e-12) << i << ' ' << k;
  }
}

TEST(Lanes, that_run_away_end_early_and_diverge) {
  LaneScene scene = make_scene();
  scene.options.duration = Rational(4);
  const Plant plant = build_plant(build_device_network(make_rc_display(), FreeOperator{}));
  const LanePlant lane_plant = make_lane_plant(plant, scene.sampling);
  const LaneDesign design{&lane_plant, *find_lane_law(Controller(VirtualWall{3, 0}), 1e-3)};
  const LaneTrace trace = trace_lanes(scene, {design}).front();
  EXPECT_TRUE(trace.stopped_early);
  EXPECT_LT(trace.position.size(), 4000u);
  const auto found =
      classify_lanes(scene, 1, [&](std::size_t, LaneDesign& d) { d = design; }).front();
  EXPECT_EQ(found.outcome, Outcome::diverges);
}

TEST(Lanes, may_be_as_short_as_a_sample) {
  for (const int samples : {1, 2, 3, 4}) {
    LaneScene scene = make_scene();
    scene.options.duration = Rational(samples, 1000);
    const Plant plant = build_plant(build_device_network(make_rc_display(), FreeOperator{}));
    const LanePlant lane_plant = make_lane_plant(plant, scene.sampling);
    const auto found = classify_lanes(scene, 20, [&](std::size_t, LaneDesign& design) {
      design = {&lane_plant, *find_lane_law(Controller(VirtualWall{0.3, 1e-4}), 1e-3)};
    });
    EXPECT_EQ(found.size(), 20u);
  }
}

TEST(Lanes, of_different_kinds_are_refused) {
  const LaneScene scene = make_scene();
  const Plant plant = build_plant(build_device_network(make_rc_display(), FreeOperator{}));
  const LanePlant at_once = make_lane_plant(plant, scene.sampling);
  const LanePlant late = make_lane_plant(plant, {Rational(1, 1000), Rational(1, 1000)});
  const LaneLaw law = *find_lane_law(Controller(VirtualWall{0.3, 1e-4}), 1e-3);
  const LaneLaw one_sided =
      *find_lane_law(Controller(VirtualWall{.stiffness = 0.3, .unilateral = true}), 1e-3);
  EXPECT_THROW(trace_lanes(scene, {{&at_once, law}, {&late, law}}), Error);
  EXPECT_THROW(trace_lanes(scene, {{&at_once, law}, {&at_once, one_sided}}), Error);
}

TEST(Lanes, do_not_depend_on_the_number_of_cores) {
  const LaneScene scene = make_scene();
  const Plant plant = build_plant(build_device_network(make_rc_display(), FreeOperator{}));
  const LanePlant lane_plant = make_lane_plant(plant, scene.sampling);
  const auto run = [&](int threads) {
    LaneOptions options;
    options.threads = threads;
    return classify_lanes(
        scene, 1000,
        [&](std::size_t i, LaneDesign& design) {
          design = {
              &lane_plant,
              *find_lane_law(Controller(VirtualWall{1e-3 * static_cast<double>(i), 1e-4}), 1e-3)};
        },
        options);
  };
  const auto one = run(1);
  const auto two = run(2);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].outcome, two[i].outcome) << i;
    EXPECT_EQ(one[i].amplitude, two[i].amplitude) << i;
  }
}

TEST(Lanes, name_what_they_cannot_do) {
  const LaneScene scene = make_scene();
  const Plant plant = build_plant(build_device_network(make_rc_display(), FreeOperator{}));
  const Controller wall = VirtualWall{0.3, 1e-4};
  EXPECT_EQ(find_lane_obstacle(plant, wall, scene), "");
  LaneScene jittering = scene;
  jittering.sampling.jitter = Rational(1, 10000);
  EXPECT_NE(find_lane_obstacle(plant, wall, jittering).find("jitter"), std::string::npos);
  const Controller adaptive =
      VirtualWall{.damping = 1e-4, .velocity = AdaptiveWindowEstimator{1e-4}};
  EXPECT_NE(find_lane_obstacle(plant, adaptive, scene).find("linear velocity"), std::string::npos);
  Device rubbing = make_rc_display();
  rubbing.mechanics.coulomb_friction = 1e-3;
  const Plant moving = build_moving_plant(build_device_network(rubbing, FreeOperator{}));
  EXPECT_NE(find_lane_obstacle(moving, wall, scene).find("not linear"), std::string::npos);
}

}  // namespace
}  // namespace gyrator
