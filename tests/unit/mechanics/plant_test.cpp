#include "gyrator/mechanics/plant.hpp"

#include "gyrator/circuits/hessenberg_response.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/mechanics/stability.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::make_device_list;
using testing::make_held_devices;
using testing::make_p3;
using testing::make_re25;

const MassSpringDamper hand{.inertia = 3e-5, .damping = 2e-4, .stiffness = 0.3, .resonators = {}};

// Rows of A are built by a few dozen eliminations.
constexpr double rounding = 1e-12;

std::vector<std::pair<std::string, Plant>> make_plants() {
  std::vector<std::pair<std::string, Plant>> plants;
  for (const auto& [name, device] : make_device_list()) {
    plants.emplace_back(name + ", free", build_plant(build_device_network(device, FreeOperator{})));
    plants.emplace_back(name + ", held", build_plant(build_device_network(device, hand)));
  }
  for (const auto& [name, device] : make_held_devices()) {
    plants.emplace_back(name + ", free", build_plant(build_device_network(device, FreeOperator{})));
    plants.emplace_back(name + ", held", build_plant(build_device_network(device, hand)));
  }
  return plants;
}

int count_near_zero(const Eigen::VectorXcd& poles) {
  const double fastest = poles.cwiseAbs().maxCoeff();
  return static_cast<int>((poles.cwiseAbs().array() < 1e-9 * fastest).count());
}

TEST(Plant, position_is_the_integral_of_velocity) {
  for (const auto& [name, plant] : make_plants()) {
    const Eigen::RowVectorXd rate = plant.port_position.state * plant.A;
    const Eigen::RowVectorXd input_rate = plant.port_position.state * plant.B;
    const double scale = (plant.port_position.state.cwiseAbs() * plant.A.cwiseAbs()).maxCoeff();
    EXPECT_LE((rate - plant.port_velocity.state).cwiseAbs().maxCoeff(), rounding * scale) << name;
    EXPECT_LE(input_rate.cwiseAbs().maxCoeff(), rounding) << name << ": velocity would jump";
    EXPECT_TRUE(plant.port_position.input.isZero(0)) << name;
    EXPECT_TRUE(plant.sensor_position.input.isZero(0)) << name;
  }
}

TEST(Plant, has_one_pole_at_zero_in_free_air_and_none_in_a_hand_with_a_spring) {
  // The operator's spring holds the position already: a second integrator of the same velocity
  // would leave an eigenvalue of one in every sampled loop.
  for (const auto& [name, plant] : make_plants()) {
    // An analog loop holds it by itself: in a hand with a spring there are two of them, equal from
    // the start to the end of every run, and one pole at zero that nothing excites.
    const bool loop = name.starts_with("held impedance");
    const bool held = name.ends_with("held");
    EXPECT_EQ(count_near_zero(compute_poles(plant.A)), held == loop ? 1 : 0) << name;
  }
}

TEST(Plant, starts_at_the_given_position_and_velocity_with_everything_moving_along) {
  for (const auto& [name, plant] : make_plants()) {
    const VectorXd xi = plant.initial_state(0.3, -2);
    const VectorXd no_input = VectorXd::Zero(2);
    EXPECT_NEAR(plant.port_position.value(xi, no_input), 0.3, rounding) << name;
    // A filter that has followed a constant velocity trails it, by 1/w_c or sqrt(2)/w_c.
    double trailing = 0;
    if (name.starts_with("filtered")) trailing = 1 / (2 * std::numbers::pi * 300);
    if (name.find(", filtered") != std::string::npos)
      trailing = std::numbers::sqrt2 / (2 * std::numbers::pi * 200);
    EXPECT_NEAR(plant.sensor_position.value(xi, no_input), 0.3 + 2 * trailing, rounding) << name;
    EXPECT_NEAR(plant.port_velocity.value(xi, no_input), -2, rounding) << name;
    for (const Signal& signal : plant.others) {
      if (signal.name != "current") continue;
      // Algebraic in two of them: K_t v/(R_m + R_1) and, fed back without a lag, -d v/K_t. An
      // analog loop answers to its position, too.
      double current = 0;
      if (name.starts_with("motor without")) current = 2 * 0.05 / 6.5;
      if (name.starts_with("back-EMF, unfiltered")) current = 2 * 3e-4 / 0.05;
      EXPECT_NEAR(signal.value(xi, no_input), current, rounding) << name;
    }
  }
}

TEST(Plant, stores_half_m_v_squared_at_the_start_of_a_run) {
  const Plant free = build_plant(build_device_network(make_p3(), FreeOperator{}));
  VectorXd z = VectorXd::Zero(free.states() + 2);
  z.head(free.states()) = free.initial_state(5, 3);
  EXPECT_NEAR(z.dot(free.energy.stored * z), 0.04 * 9 / 2, rounding);
  // The hand's own energy is not the device's.
  const Plant held = build_plant(build_device_network(make_p3(), hand));
  z.head(held.states()) = held.initial_state(5, 3);
  EXPECT_NEAR(z.dot(held.energy.stored * z), 0.04 * 9 / 2, rounding);
}

TEST(Plant, power_balances_on_every_state_after_positions_have_been_added) {
  for (const auto& [name, plant] : make_plants()) {
    const Eigen::Index n = plant.states();
    MatrixXd M = MatrixXd::Zero(n + 2, n + 2);
    M.topRows(n) << plant.A, plant.B;
    const auto& e = plant.energy;
    ASSERT_EQ(e.stored.rows(), n + 2) << name;
    ASSERT_EQ(e.source_jump.rows(), n + 4) << name;
    const MatrixXd change = M.transpose() * e.stored + e.stored * M;
    const MatrixXd residual = e.source + e.operator_work - change - e.dissipated;
    // Row by row (units differ by 1e12) against the terms that cancel in it.
    const MatrixXd terms = M.cwiseAbs().transpose() * e.stored.cwiseAbs() +
                           e.stored.cwiseAbs() * M.cwiseAbs() + e.source.cwiseAbs() +
                           e.operator_work.cwiseAbs() + e.dissipated.cwiseAbs();
    for (Eigen::Index i = 0; i < residual.rows(); ++i) {
      EXPECT_LE(residual.row(i).cwiseAbs().maxCoeff(), rounding * terms.row(i).maxCoeff())
          << name << " row " << i;
    }
  }
}

TEST(Plant, gives_the_networks_frequency_response_from_command_to_sensor) {
  for (const auto& [name, device] : make_device_list()) {
    const DeviceNetwork network = build_device_network(device, hand);
    const NetworkEquations equations(network.network);
    const Plant plant = build_plant(network);
    HessenbergResponse response(
        {plant.A, plant.B.col(0), plant.sensor_position.state, MatrixXd::Zero(1, 1)});
    Eigen::MatrixXcd found;
    for (const double hz : {0.1, 3.0, 40.0, 700.0, 2e3}) {
      const Complex s(0, 2 * std::numbers::pi * hz);
      const Eigen::MatrixXcd x = solve_descriptor(equations.descriptor(), s);
      const Complex wanted = (find_sensed_rate(network, equations).x * x)(network.command) / s;
      // A filtered position is the true one less what it trails by.
      const Complex moved = (equations.across(network.port).x * x)(network.command) / s;
      response.evaluate(s, found);
      const double size = std::max(std::abs(wanted), network.filter.empty() ? 0 : std::abs(moved));
      EXPECT_LE(std::abs(found(0, 0) - wanted), 1e-9 * size) << name << " at " << hz;
    }
  }
}

TEST(Plant, tells_current_and_voltage_where_a_step_leaves_them_finite) {
  const auto names = [](const Device& device) {
    std::vector<std::string> all;
    for (const Signal& s : build_plant(build_device_network(device, FreeOperator{})).others) {
      all.push_back(s.name);
    }
    return all;
  };
  EXPECT_TRUE(names(make_p3()).empty()) << "no motor";
  EXPECT_EQ(names(make_re25()), std::vector<std::string>{"current"}) << "voltage has an impulse";
  EXPECT_EQ(names(testing::make_rc_display()), (std::vector<std::string>{"current", "voltage"}));
}

TEST(Plant, an_effort_that_would_be_the_derivative_of_the_command_is_refused_by_name) {
  // The command sets the port's velocity itself, so that a step of it throws the hand's mass.
  DeviceNetwork device;
  Network& network = device.network;
  network.add_input("command");
  network.add_input("external_effort");
  device.port = network.add_node("port", Domain::mechanical);
  const NodeId mass = network.add_node("hand", Domain::mechanical);
  network.add("velocity", device.port, ground, VoltageSource{0});
  device.operator_ammeter = network.add("ammeter", mass, device.port, VoltageSource{});
  network.add("mass", mass, ground, Capacitor{1});
  try {
    build_plant(device);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::numerical);
    EXPECT_EQ(error.place(), "effort");
  }
}

// ---- stability of the device alone

// A loop around the motor current with R_1 and C across the terminals, rotor clamped:
//   L C s^3 + (R + R_1) C s^2 + (1 + w_b R_1 C) s + w_b = 0,
// stable below the Routh limit (R + R_1)(1 + w_b R_1 C) = L w_b.
constexpr double R = 2.06, L = 0.238e-3, C = 1e-3;  // RE25
Device make_motor_sensed(double resistance, double w_b) {
  Device device = make_re25();
  device.drive.amplifier =
      CurrentAmplifier{.bandwidth_hz = w_b / (2 * std::numbers::pi), .sense = CurrentSense::motor};
  device.drive.damping = {RcDamping{resistance, C}};
  return device;
}

TEST(UnstablePole, of_a_motor_current_loop_appears_exactly_at_the_routh_limit) {
  // R_1 = 0: w_b = R/L, which is 1378 Hz. With R_1 > 0 the condition holds for every w_b unless
  // (R + R_1) R_1 C < L: 0.05 ohm is below that, w_b = (R + R_1)/(L - (R + R_1) R_1 C).
  for (const double R_1 : {0.0, 0.05}) {
    const double limit = (R + R_1) / (L - (R + R_1) * R_1 * C);
    ASSERT_GT(limit, 0);
    for (const double side : {0.5, 0.999, 1.001, 2.0}) {
      const double w_b = side * limit;
      const auto pole =
          find_unstable_pole(build_device_network(make_motor_sensed(R_1, w_b), ClampedOperator{}));
      ASSERT_EQ(pole.has_value(), side > 1) << "R_1 = " << R_1 << ", " << side << " of the limit";
      if (!pole) continue;
      EXPECT_EQ(pole->element, "damping.0.capacitance") << "half of the energy, and exactly so";
      const Complex s(pole->real, pole->imag);
      const Complex residue =
          L * C * s * s * s + (R + R_1) * C * s * s + (1 + w_b * R_1 * C) * s + w_b;
      EXPECT_LE(std::abs(residue), 1e-9 * w_b);  // a root of a cubic, to rounding / distance
    }
    // At the limit itself the loop oscillates at sqrt((1 + w_b R_1 C)/(L C)).
    const auto pole = find_unstable_pole(
        build_device_network(make_motor_sensed(R_1, limit * 1.0001), ClampedOperator{}));
    ASSERT_TRUE(pole.has_value());
    EXPECT_NEAR(pole->imag / std::sqrt((1 + limit * R_1 * C) / (L * C)), 1, 1e-3);
  }
  EXPECT_FALSE(
      find_unstable_pole(build_device_network(make_motor_sensed(2, 1e6), ClampedOperator{})));
}

TEST(UnstablePole, is_named_with_the_port_condition_where_a_device_is_required_to_be_stable) {
  EXPECT_NO_THROW(require_stable_device(make_motor_sensed(0, 0.99 * R / L)));
  try {
    require_stable_device(make_motor_sensed(0, 2 * R / L));
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::numerical);
    EXPECT_TRUE(error.place().starts_with("damping.0") || error.place().starts_with("motor."))
        << error.place();
    EXPECT_NE(error.message().find("port "), std::string::npos);
    EXPECT_NE(error.message().find("bandwidth"), std::string::npos);
  }
}

TEST(UnstablePole, there_is_none_in_any_device_of_the_list) {
  for (const auto& [name, device] : make_device_list()) {
    EXPECT_NO_THROW(require_stable_device(device)) << name;
  }
}

}  // namespace
}  // namespace gyrator
