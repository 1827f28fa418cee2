#include "gyrator/mechanics/plant_dynamics.hpp"

#include "gyrator/circuits/operating_point.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "support/nonlinear_devices.hpp"

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(PlantDynamics, has_the_jacobian_of_its_rate) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  for (const auto& [name, device] : testing::make_nonlinear_devices()) {
    const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
    PlantDynamics dynamics(plant);
    const Index n = plant.states();
    for (int draw = 0; draw < 20; ++draw) {
      VectorXd xi(n);
      for (Index i = 0; i < n; ++i) xi(i) = normal(generator);
      const Eigen::Vector2d u(0.1 * normal(generator), 0.1 * normal(generator));
      dynamics.solve(xi, u);
      const MatrixXd jacobian = dynamics.jacobian(xi);
      const VectorXd at = dynamics.rate(xi);
      for (Index j = 0; j < n; ++j) {
        const double h = 1e-6;
        VectorXd moved = xi;
        moved(j) += h;
        dynamics.solve(moved, u);
        const VectorXd up = dynamics.rate(moved);
        moved(j) -= 2 * h;
        dynamics.solve(moved, u);
        const VectorXd down = dynamics.rate(moved);
        for (Index i = 0; i < n; ++i) {
          // Rounding of the rate over h, as the stiffest entry of its row makes it.
          const double row = jacobian.row(i).cwiseAbs().maxCoeff();
          const double rounding = 1e-9 * (std::abs(at(i)) + row) + 1e-9;
          // A kink may lie within h: one of the sides must agree then.
          const double left = std::abs((at(i) - down(i)) / h - jacobian(i, j));
          const double right = std::abs((up(i) - at(i)) / h - jacobian(i, j));
          // Heat is quadratic: only the central difference is then without an error of h.
          const double central = std::abs((up(i) - down(i)) / (2 * h) - jacobian(i, j));
          EXPECT_LE(std::min({left, right, central}), rounding + 1e-5 * row)
              << name << ' ' << i << ' ' << j;
        }
      }
    }
  }
}

TEST(PlantDynamics, at_rest_has_the_tangent_that_the_linear_tools_use) {
  for (const auto& [name, device] : testing::make_nonlinear_devices()) {
    const Plant plant = build_moving_plant(build_device_network(device, FreeOperator{}));
    PlantDynamics dynamics(plant);
    const VectorXd rest = plant.initial_state(0, 0);
    dynamics.solve(rest, {0, 0});
    const MatrixXd jacobian = dynamics.jacobian(rest);
    EXPECT_LE((jacobian - plant.A).norm(), 1e-9 * plant.A.norm()) << name;
    EXPECT_LE(dynamics.rate(rest).head(1).norm(), 1e-12) << name;
  }
}

TEST(PlantDynamics, a_linear_device_moves_as_the_linear_tools_have_it) {
  for (const auto& [name, device] : testing::make_device_list()) {
    const DeviceNetwork network = build_device_network(device, FreeOperator{});
    const Plant moving = build_moving_plant(network);
    EXPECT_FALSE(moving.nonlinear) << name;
    EXPECT_EQ(moving.A, build_plant(network).A) << name;
  }
}

TEST(PlantDynamics, refuses_what_would_need_the_derivative_of_a_limited_quantity) {
  // An ideal current source that follows the motor's back-EMF, bounded, into an inductance.
  Device device = testing::make_rc_display();
  device.drive.damping = {BackEmfDamping{.damping = 1e-4,
                                         .resistance_estimate = 1.5,
                                         .inductance_estimate = 0.5e-3,
                                         .low_pass_hz = 100,
                                         .high_pass_hz = {}}};
  device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = {}, .current_limit = 1};
  try {
    (void)build_moving_plant(build_device_network(device, FreeOperator{}));
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::numerical);
    EXPECT_NE(error.message().find("derivative"), std::string::npos) << error.message();
  }
}

}  // namespace
}  // namespace gyrator
