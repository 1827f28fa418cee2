#include "gyrator/mechanics/plant_modes.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/contact_devices.hpp"

namespace gyrator {
namespace {

using Eigen::VectorXd;

constexpr double rounding = 1e-12;

Device make_block() {
  Device device = testing::make_p3();  // 0.04 kg, 0.8 N.s/m
  device.mechanics.coulomb_friction = 0.3;
  device.mechanics.stiction = 0.5;
  device.mechanics.stribeck_velocity = 0.1;
  device.mechanics.stops = HardStops{.lower = -1, .upper = 2, .stiffness = 50, .damping = 4};
  return device;
}

struct Block {
  Plant plant = build_moving_plant(build_device_network(make_block(), FreeOperator{}));
  PlantModes modes{plant, true};

  // [ξ; U] in a mode, at a position, a velocity and a command.
  VectorXd at(const Modes& mode, double x, double v, double command) const {
    VectorXd z = VectorXd::Zero(plant.states() + plant.inputs());
    z.head(plant.states()) = plant.initial_state(x, v);
    z(plant.states()) = command;
    z(z.size() - 1) = 1;
    z.tail(plant.inputs()) = modes.close(mode) * z;
    return z;
  }
  double friction(const Modes& mode, double v, double command = 0) const {
    return at(mode, 0, v, command)(plant.states() + NonlinearPart::friction_input);
  }
};

// The equations in contact.hpp, evaluated.
TEST(PlantModes, friction_is_the_law_of_its_header_in_every_mode) {
  const Block block;
  for (const double v : {0.0, 0.03, 0.1, 0.4}) {
    const double level = 0.3 + 0.2 * std::max(0.0, 1 - v / 0.1);
    const auto zone = static_cast<signed char>(v > 0.1 ? 2 : 1);
    EXPECT_NEAR(block.friction({zone, 0}, v), -level, rounding);
    EXPECT_NEAR(block.friction({static_cast<signed char>(-zone), 0}, -v), level, rounding);
  }
  // Held at rest it takes what the command leaves, and nothing moves.
  EXPECT_NEAR(block.friction({0, 0}, 0, 0.37), -0.37, rounding);
}

TEST(PlantModes, a_stop_pushes_back_by_spring_and_damper_and_never_pulls) {
  const Block block;
  const auto n = block.plant.states();
  const auto effort = [&](const Modes& mode, double x, double v) {
    return block.at(mode, x, v, 0)(n + NonlinearPart::stop_input);
  };
  EXPECT_NEAR(effort({1, 1}, 2.1, 0.2), -(50 * 0.1 + 4 * 0.2), rounding);
  EXPECT_NEAR(effort({1, -1}, -1.1, -0.2), 50 * 0.1 + 4 * 0.2, rounding);
  EXPECT_EQ(effort({1, 2}, 2.1, -3), 0);
  EXPECT_EQ(effort({1, 0}, 1.9, 3), 0);
  EXPECT_EQ(block.modes.start(block.plant.initial_state(2.1, 0.2)), (Modes{2, 1}));
  EXPECT_EQ(block.modes.start(block.plant.initial_state(2.1, -3)), (Modes{-2, 2}));
  EXPECT_EQ(block.modes.start(block.plant.initial_state(-1.1, -0.05)), (Modes{-1, -1}));
  EXPECT_EQ(block.modes.start(block.plant.initial_state(0, 0)), (Modes{0, 0}));
}

// In every mode the powers of the network and of the contacts add up (led-1).
TEST(PlantModes, power_in_equals_stored_and_lost_in_every_mode) {
  const Block block;
  const auto& e = block.plant.energy;
  for (const Modes& mode : {Modes{1, 0}, Modes{2, 1}, Modes{-1, -1}, Modes{-2, 2}, Modes{1, -2}}) {
    const double x = mode[1] > 0 ? 2.1 : mode[1] < 0 ? -1.2 : 0.3;
    const double v = mode[0] > 0 ? 0.07 : -0.3;
    const VectorXd z = block.at(mode, x, v, 0.2);
    const auto n = block.plant.states();
    const VectorXd rate = block.plant.nonlinear->A * z.head(n) +
                          block.plant.nonlinear->B * z.tail(block.plant.inputs());
    // dU/dt: of the deflection alone matters in what is stored.
    VectorXd dz = VectorXd::Zero(z.size());
    dz.head(n) = rate;
    if (mode[1] != 0) dz(n + NonlinearPart::deflection_input) = v;
    const double in = z.dot(e.source * z) + z.dot(e.operator_work * z);
    const double out = 2 * z.dot(e.stored * dz) + z.dot(e.dissipated * z);
    EXPECT_NEAR(in, out, rounding) << int(mode[0]) << ' ' << int(mode[1]);
    const bool leaves = std::abs(mode[1]) == 2 && v * mode[1] < 0;
    if (std::abs(mode[1]) != 2 || leaves) {
      EXPECT_GT(z.dot(e.dissipated * z), 0);
    }
  }
}

TEST(PlantModes, a_clamped_shaft_knows_no_friction) {
  const Plant plant = build_moving_plant(build_device_network(make_block(), ClampedOperator{}));
  const PlantModes modes(plant, true);
  EXPECT_FALSE(modes.sticks({0, 0}));
  for (const ModeGuard& guard : modes.guards({0, 0})) EXPECT_NE(guard.part, 0);
}

TEST(PlantModes, each_mode_begins_where_the_one_before_ended) {
  // Across a guard, efforts of friction's zones and of the circuit's bends do not jump.
  for (const auto& [name, device] : testing::make_contact_devices()) {
    const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
    const PlantModes modes(plant, true);
    const auto n = plant.states();
    VectorXd z = VectorXd::Zero(n + plant.inputs());
    z.head(n) = plant.initial_state(0.001, 0.05) + VectorXd::LinSpaced(n, 1e-3, 2e-3);
    z(z.size() - 1) = 1;
    Modes from = modes.start(z.head(n));
    for (const ModeGuard& guard : modes.guards(from)) {
      const bool bends =
          guard.part >= modes.first_port() || (guard.part == 0 && std::abs(guard.next) == 2);
      if (!bends) continue;
      // Along the gradient of the guard to where it is zero.
      const auto close = modes.close(from);
      const auto value = [&] {
        z.tail(plant.inputs()) = close * z;
        return guard.row.dot(z);
      };
      const Eigen::RowVectorXd gradient =
          guard.row.head(n) + guard.row.tail(plant.inputs()) * close.leftCols(n);
      if (gradient.norm() == 0) continue;
      const double off = value();
      z.head(n) -= off / gradient.squaredNorm() * gradient.transpose();
      ASSERT_NEAR(value(), 0, 1e-9 * std::abs(off)) << name;
      const VectorXd before = z;
      Modes to = from;
      to[guard.part] = guard.next;
      const VectorXd after = modes.close(to) * z;
      EXPECT_LE((after - before.tail(plant.inputs())).norm(), 1e-9 * (1 + after.norm())) << name;
    }
  }
}

TEST(DryFriction, contradictions_are_refused_by_key) {
  const auto place_of = [](const auto& change) -> std::string {
    Device device = make_block();
    change(device.mechanics);
    try {
      (void)build_device_network(device, FreeOperator{});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return error.place();
    }
    return "";
  };
  EXPECT_EQ(place_of([](Mechanics&) {}), "");
  EXPECT_EQ(place_of([](Mechanics& m) { m.stiction = 0.2; }), "mechanics/stiction");
  EXPECT_EQ(place_of([](Mechanics& m) { m.coulomb_friction = -1; }), "mechanics/coulomb_friction");
  EXPECT_EQ(place_of([](Mechanics& m) { m.stribeck_velocity = -1; }),
            "mechanics/stribeck_velocity");
  EXPECT_EQ(place_of([](Mechanics& m) { m.stiction = std::nullopt; }),  // falls from 0.3 to 0.3
            "mechanics/stribeck_velocity");
  EXPECT_EQ(place_of([](Mechanics& m) { m.stops->upper = -1; }), "mechanics/stops/upper");
  EXPECT_EQ(place_of([](Mechanics& m) { m.stops->stiffness = 0; }), "mechanics/stops/stiffness");
  EXPECT_EQ(place_of([](Mechanics& m) { m.stops->damping = -1; }), "mechanics/stops/damping");
  EXPECT_EQ(place_of([](Mechanics& m) { m.stops->lower = m.stops->upper = std::nullopt; }),
            "mechanics/stops");
}

TEST(DryFriction, the_linear_plant_leaves_contacts_out) {
  Device device = make_block();
  const Plant with = build_plant(build_device_network(device, FreeOperator{}));
  device.mechanics.stribeck_velocity = 0;
  device.mechanics.coulomb_friction = 0;
  device.mechanics.stiction.reset();
  device.mechanics.stops.reset();
  const DeviceNetwork plain = build_device_network(device, FreeOperator{});
  EXPECT_EQ(with.A, build_plant(plain).A);
  EXPECT_EQ(with.B, build_plant(plain).B);
  EXPECT_FALSE(build_moving_plant(plain).nonlinear);
}

}  // namespace
}  // namespace gyrator
