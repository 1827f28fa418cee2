#include "gyrator/controllers/virtual_coupling.hpp"

#include "gyrator/controllers/controller.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double T = 1e-3, K = 300, B = 0.2, m = 0.01, tool_damping = 0.05;
constexpr double rounding = 1e-9;  // relative; of sums over at most a few thousand steps
constexpr Integration schemes[] = {Integration::explicit_euler, Integration::semi_implicit,
                                   Integration::implicit};

VirtualCoupling make(Integration integration) {
  VirtualCoupling coupling;
  coupling.coupling = {K, B};
  coupling.tool_inertia = m;
  coupling.tool_damping = tool_damping;
  coupling.integration = integration;
  return coupling;
}

// By substitution: backward difference d = (z - 1)/(T z), forward difference f = (z - 1)/T.
//   explicit       w = f p,  m f w = F - b w - ...,  F = K (y - p) + B (d y - f p)
//   semi-implicit  w = d p,  m f w = F - b w - ...,  F = K (y - p) + B d (y - p)
//   implicit       w = d p,  m d w = F - b w - ...,  the same F
Complex expected_law(const VirtualCoupling& c, Complex z) {
  const Complex d = (z - 1.0) / (T * z), f = (z - 1.0) / T;
  const Complex rate = c.integration == Integration::explicit_euler ? f : d;
  const Complex inertia = (c.integration == Integration::implicit ? d : f) * rate * c.tool_inertia;
  Complex tool = inertia + c.tool_damping * rate;
  if (c.wall) tool += c.wall->law.stiffness + c.wall->law.damping * rate;
  const Complex from_device = c.coupling.stiffness + c.coupling.damping * d;
  const Complex from_tool = c.coupling.stiffness + c.coupling.damping * rate;
  return from_device * tool / (from_tool + tool);
}

TEST(VirtualCoupling, has_the_transfer_function_that_substitution_gives) {
  for (const Integration scheme : schemes) {
    VirtualCoupling c = make(scheme);
    for (const bool wall : {false, true}) {
      if (wall) c.wall = ToolWall{{2000, 1.5}, 0.02, false};
      for (const double angle : {0.01, 0.3, 1.7, std::numbers::pi}) {
        const Complex z = std::polar(1.0, angle);
        const Complex expected = expected_law(c, z);
        EXPECT_LE(std::abs(find_linear_law(c, T)->response(z) - expected),
                  1e-9 * (std::abs(expected) + K))
            << name_of(scheme) << " " << wall << " " << angle;
      }
    }
  }
}

TEST(VirtualCoupling, runs_the_law_that_its_transfer_function_tells) {
  for (const Integration scheme : schemes) {
    VirtualCoupling c = make(scheme);
    c.coupling.damping = 1;  // decays: explicit needs B + b_t > K T
    c.substeps = 3;
    const double angle = 0.3;
    const Complex z = std::polar(1.0, angle);
    const Complex H = find_linear_law(c, T)->response(z);
    RunningController cosine(c, T), sine(c, T);
    for (int k = 0; k < 3000; ++k) {
      const Complex y = std::polar(1.0, angle * k);
      const Complex command(cosine.step(y.real()), sine.step(y.imag()));
      if (k < 2000) continue;
      ASSERT_LE(std::abs(command + H * y), rounding * (std::abs(H) + K)) << name_of(scheme);
    }
  }
}

TEST(VirtualCoupling, the_undamped_tool_swings_at_the_frequency_of_its_scheme) {
  // On its spring: |z| and the angle of the pole of each scheme, with w = sqrt(K/m) T.
  const double w = std::sqrt(K / m) * T;
  for (const Integration scheme : schemes) {
    VirtualCoupling c = make(scheme);
    c.coupling.damping = c.tool_damping = 0;
    const Complex pole = [&] {
      const auto law = make_coupling_law(c, T);
      Complex found;
      for (const auto& z : law.A.eigenvalues())
        if (z.imag() > std::imag(found)) found = z;
      return found;
    }();
    double magnitude = 1, angle = 2 * std::asin(w / 2);  // semi-implicit
    if (scheme == Integration::explicit_euler) {
      magnitude = std::sqrt(1 + w * w);
      angle = std::atan(w);
    } else if (scheme == Integration::implicit) {
      magnitude = 1 / std::sqrt(1 + w * w);
      angle = std::atan(w);
    }
    EXPECT_NEAR(std::abs(pole), magnitude, rounding) << name_of(scheme);
    EXPECT_NEAR(std::arg(pole), angle, rounding) << name_of(scheme);
  }
}

// Energy of tool and spring after `steps` with the device held at 0, over that at the start.
double energy_left(Integration scheme, int steps, double* lowest = nullptr,
                   double* highest = nullptr) {
  ChainModel model;
  model.inertia[0] = m;
  model.links[0] = {{K, 0}, false};
  model.integration = scheme;
  VirtualChain chain(model, T);
  chain.place({{1e-3, 0}, {0, 0}});
  const auto energy = [&] {
    const auto& s = chain.state();
    return 0.5 * m * s.velocity[0] * s.velocity[0] + 0.5 * K * s.position[0] * s.position[0];
  };
  const double start = energy();
  for (int k = 0; k < steps; ++k) {
    chain.advance(0, 0);
    if (lowest) *lowest = std::min(*lowest, energy() / start);
    if (highest) *highest = std::max(*highest, energy() / start);
  }
  return energy() / start;
}

TEST(VirtualCoupling, each_scheme_makes_the_energy_that_it_is_known_for) {
  const double ww = K / m * T * T;  // (w T)^2 = 0.03
  constexpr int steps = 500;
  EXPECT_NEAR(energy_left(Integration::explicit_euler, steps) / std::pow(1 + ww, steps), 1, 1e-10);
  EXPECT_NEAR(energy_left(Integration::implicit, steps) * std::pow(1 + ww, steps), 1, 1e-10);
  // m v^2 + K x^2 - K T x v is kept: the energy itself swings within 1/(1 -+ wT/2) of it.
  double lowest = 1, highest = 1;
  energy_left(Integration::semi_implicit, 100'000, &lowest, &highest);
  const double half = std::sqrt(ww) / 2;
  EXPECT_GT(lowest, (1 - half) / (1 + half));
  EXPECT_LT(highest, (1 + half) / (1 - half));
  EXPECT_GT(highest - lowest, half);  // it does swing
}

TEST(VirtualCoupling, presses_its_tool_into_a_wall_until_both_springs_agree) {
  // K (y - p) = K_e (p - x_w): with y = 30 mm, x_w = 10 mm.
  const double wall_stiffness = 700, y = 0.03, at = 0.01;
  const double p = (K * y + wall_stiffness * at) / (K + wall_stiffness);
  for (const Integration scheme : schemes) {
    for (const auto& period : {std::optional<Rational>{}, std::optional(Rational(1, 60))}) {
      VirtualCoupling c = make(scheme);
      c.wall = ToolWall{{wall_stiffness, 3}, at, true};
      c.tool_damping = 3;
      c.substeps = 20;
      c.update.period = period;
      RunningVirtualCoupling running(c, T);
      running.step(0);
      double command = 0;
      for (int k = 0; k < 5000; ++k) command = running.step(y);
      EXPECT_NEAR(running.tool_position(), p, rounding) << name_of(scheme);
      EXPECT_NEAR(command, -K * (y - p), K * rounding) << name_of(scheme);
    }
  }
}

TEST(VirtualCoupling, an_implicit_tool_that_its_walls_damper_stops_short_stops_at_the_wall) {
  // Free it would pass the wall, with all of the wall's damping it would not reach it: the effort
  // in between that ends the step at the surface is the solution.
  ChainModel model;
  model.inertia[0] = m;
  model.links[1] = {{1000, 100}, true};
  model.integration = Integration::implicit;
  VirtualChain chain(model, T);
  chain.place({{-1e-4, 0}, {1, 0}});
  chain.advance(0, 0);
  EXPECT_NEAR(chain.state().position[0], 0, 1e-15);
  EXPECT_NEAR(chain.state().velocity[0], 0.1, 1e-12);
}

TEST(VirtualCoupling, starts_without_effort_wherever_the_device_is) {
  for (const Integration scheme : schemes) {
    RunningController running(make(scheme), T);
    for (int k = 0; k < 10; ++k) EXPECT_EQ(running.step(0.7), 0.0);
  }
}

TEST(VirtualCoupling, a_slow_tool_stands_still_between_its_updates) {
  VirtualCoupling c = make(Integration::implicit);
  c.update = {.period = Rational(1, 60), .delay = Rational(1, 100)};
  RunningVirtualCoupling running(c, T);
  double before = 0;
  int moves = 0;
  for (int k = 0; k < 600; ++k) {
    running.step(0.01 * std::sin(0.01 * k));
    if (running.tool_position() != before) ++moves;
    before = running.tool_position();
  }
  EXPECT_EQ(moves, 35);  // 36 updates in 0.6 s, the first of which finds the tool at rest at 0
  EXPECT_FALSE(find_linear_law(c, T).has_value());
}

}  // namespace
}  // namespace gyrator
