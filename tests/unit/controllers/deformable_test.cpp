#include "gyrator/controllers/deformable.hpp"

#include "gyrator/controllers/controller.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double T = 1e-3;
constexpr double rounding = 1e-9;
const Rational thirtieth(1, 30);

// Table 1 of Kim and Lee 2017.
DeformableScene make_scene(Integration integration, int substeps = 1) {
  DeformableScene scene;
  scene.object = {1, {300, 0.06}, 0};
  scene.contact = {300, 0.06};
  scene.integration = integration;
  scene.substeps = substeps;
  return scene;
}

TEST(DeformableObject, is_felt_through_all_springs_in_series_at_rest) {
  DeformableScene scene = make_scene(Integration::implicit);
  scene.object.to_ground.damping = 30;  // to come to rest
  scene.object.position = 0.01;
  scene.update.period = thirtieth;
  const double y = 0.025, depth = 0.015;
  for (const bool unilateral : {false, true}) {
    scene.unilateral = unilateral;
    const auto settled = [&](const Law& law) {
      RunningController running(Controller(law, {}), T);
      double command = running.step(0);
      for (int k = 0; k < 60'000; ++k) command = running.step(y);
      return -command / depth;
    };
    EXPECT_NEAR(settled(DirectRendering{scene}), 150, 300 * rounding);
    EXPECT_NEAR(settled(ProxyRendering{scene, 1e-4, {150, 0.06}}), 75, 300 * rounding);
    EXPECT_NEAR(settled(EquivalentImpedance{scene}), 150, 300 * rounding);
    DeformableScene stiff = scene;
    stiff.contact = {3000, 1};
    EXPECT_NEAR(settled(EquivalentImpedance{stiff}), 3000.0 / 11, 3000 * rounding);
  }
}

// All three in the loop, implicit: s -> (z - 1)/(T z) in the continuous impedance.
TEST(DeformableObject, in_the_loop_has_the_transfer_function_that_substitution_gives) {
  DeformableScene scene = make_scene(Integration::implicit);
  scene.unilateral = false;
  for (const double angle : {0.02, 0.3, 2.0, 3.14}) {
    const Complex z = std::polar(1.0, angle);
    const Complex s = (z - 1.0) / (T * z);
    const Complex object = s * s + 0.06 * s + 300.0, contact = 300.0 + 0.06 * s;
    const Complex touched = contact * object / (contact + object);
    const Complex carried = 1e-4 * s * s + touched;
    const auto expect = [&](const Law& law, Complex expected) {
      const auto found = find_linear_law(Controller(law, {}), T);
      ASSERT_TRUE(found.has_value());
      EXPECT_LE(std::abs(found->response(z) - expected), 1e-8 * std::abs(contact)) << angle;
    };
    expect(DirectRendering{scene}, touched);
    expect(EquivalentImpedance{scene}, touched);
    expect(ProxyRendering{scene, 1e-4, {300, 0.06}}, contact * carried / (contact + carried));
  }
}

TEST(DeformableObject, runs_the_law_that_its_transfer_function_tells) {
  DeformableScene scene = make_scene(Integration::semi_implicit, 2);
  scene.object.to_ground.damping = 20;
  scene.unilateral = false;
  const Law laws[] = {DirectRendering{scene}, ProxyRendering{scene, 0.01, {300, 0.5}},
                      EquivalentImpedance{scene}};
  for (const Law& law : laws) {
    const Controller controller(law, {});
    const Complex z = std::polar(1.0, 0.1);
    const Complex H = find_linear_law(controller, T)->response(z);
    RunningController cosine(controller, T), sine(controller, T);
    for (int k = 0; k < 12'000; ++k) {
      const Complex y = std::polar(1.0, 0.1 * k);
      const Complex command(cosine.step(y.real()), sine.step(y.imag()));
      if (k < 11'000) continue;
      ASSERT_LE(std::abs(command + H * y), rounding * 300) << law.index();
    }
  }
}

TEST(DeformableObject, only_pushes_and_only_in_penetration) {
  DeformableScene scene = make_scene(Integration::semi_implicit);
  scene.object.position = 0.005;
  for (const Integration scheme :
       {Integration::explicit_euler, Integration::semi_implicit, Integration::implicit}) {
    scene.integration = scheme;
    for (const auto& period : {std::optional<Rational>{}, std::optional(Rational(1, 60))}) {
      scene.update.period = period;
      RunningHeldRendering direct(DirectRendering{scene}, T);
      RunningEquivalentImpedance equivalent(EquivalentImpedance{scene}, T);
      double most = 0;
      for (int k = 0; k < 3000; ++k) {
        const double y = 0.012 * std::sin(0.013 * k);
        const double before = equivalent.felt_surface();
        const double command = equivalent.step(y);
        if (!period && y < before - 1e-3) {
          EXPECT_EQ(command, 0) << k;
        }
        EXPECT_LE(command, 0);
        EXPECT_LE(direct.step(y), 0);
        most = std::min(most, command);
      }
      EXPECT_LT(most, -0.1);
    }
  }
}

TEST(DeformableObject, a_light_tool_at_thirty_hertz_needs_the_substeps_that_its_mode_asks_for) {
  // Between two springs k and dampers c the semi-implicit tool is stable for
  //   2 k h^2/m < 4 - 2 (2 c h/m),   h < (-2 c + sqrt(4 c^2 + 8 k m))/(2 k) = 0.6406 ms,
  // the object, ten thousand times as heavy, standing still: 53 substeps of 1/30 s, not 52.
  const double k = 300, c = 0.06, mass = 1e-4;
  const double longest = (-2 * c + std::sqrt(4 * c * c + 8 * k * mass)) / (2 * k);
  const int enough = static_cast<int>(std::ceil(1.0 / 30 / longest));
  EXPECT_EQ(enough, 53);
  const auto radius = [&](Integration integration, int substeps) {
    DeformableScene scene = make_scene(integration, substeps);
    scene.unilateral = false;
    const ProxyRendering proxy{scene, mass, {k, c}};
    return make_deformable_law(proxy, 1.0 / 30).A.eigenvalues().cwiseAbs().maxCoeff();
  };
  EXPECT_GT(radius(Integration::semi_implicit, 1), 1000);
  EXPECT_GT(radius(Integration::semi_implicit, enough - 1), 1);
  EXPECT_LT(radius(Integration::semi_implicit, enough), 1);
  EXPECT_LT(radius(Integration::implicit, 1), 1);
  EXPECT_GT(radius(Integration::explicit_euler, enough), 1);
}

TEST(EquivalentImpedance, in_contact_feels_nothing_of_rate_delay_and_losses) {
  DeformableScene scene = make_scene(Integration::semi_implicit);
  scene.unilateral = false;
  RunningController in_loop(EquivalentImpedance{scene}, T);
  scene.update = {.period = thirtieth, .delay = Rational(1, 20), .loss = 0.4, .seed = 3};
  RunningController behind(EquivalentImpedance{scene}, T);
  ASSERT_TRUE(find_linear_law(EquivalentImpedance{scene}, T).has_value());
  for (int k = 0; k < 2000; ++k) {
    const double y = 0.01 * std::sin(0.03 * k);
    ASSERT_EQ(in_loop.step(y), behind.step(y)) << k;
  }
}

TEST(EquivalentImpedance, keeps_its_copy_while_it_is_touched) {
  DeformableScene scene = make_scene(Integration::semi_implicit);
  scene.object.to_ground.damping = 30;
  RunningController in_loop(EquivalentImpedance{scene}, T);
  scene.update = {.period = thirtieth, .delay = Rational(1, 50), .loss = 0.2, .seed = 2};
  RunningController behind(EquivalentImpedance{scene}, T);
  for (int k = 0; k < 2000; ++k) {
    const double y = 0.01 + 0.002 * std::sin(0.03 * k);
    const double command = behind.step(y);
    ASSERT_LT(command, 0) << "never let go";
    ASSERT_EQ(in_loop.step(y), command) << k;
  }
}

TEST(EquivalentImpedance, its_slow_object_follows_the_copy_that_is_felt) {
  DeformableScene scene = make_scene(Integration::implicit, 8);
  scene.object.to_ground.damping = 10;
  scene.update.period = thirtieth;
  RunningEquivalentImpedance running(EquivalentImpedance{scene}, T);
  for (int k = 0; k < 20'000; ++k) running.step(0.01);
  EXPECT_NEAR(running.felt_surface(), 0.005, rounding);
  EXPECT_NEAR(running.surface_position(), 0.005, rounding);
}

TEST(EquivalentImpedance, out_of_contact_the_copy_takes_the_conveyed_surface) {
  DeformableScene scene = make_scene(Integration::semi_implicit);
  scene.update.period = thirtieth;
  RunningEquivalentImpedance running(EquivalentImpedance{scene}, T);
  for (int k = 0; k < 500; ++k) running.step(0.01);  // press …
  // … and let go. The slow object swings on at its own frequency, and the copy with it: without
  // being set right it would be off by more than the swing itself after some seconds.
  double largest = 0;
  for (int k = 0; k < 20'000; ++k) {
    EXPECT_EQ(running.step(-1), 0);
    // At most one period and a tick old: 34 ms at the speed of the swing.
    const double off = std::abs(running.felt_surface() - running.surface_position());
    largest = std::max(largest, off);
  }
  EXPECT_GT(largest, 1e-4);
  EXPECT_LT(largest, 0.01 * std::sqrt(300.0) * 0.034 * 1.5);
}

TEST(DeformableObject, behind_the_loop_has_no_linear_law) {
  DeformableScene scene = make_scene(Integration::implicit);
  scene.unilateral = false;
  EXPECT_TRUE(find_linear_law(DirectRendering{scene}, T).has_value());
  scene.update.period = thirtieth;
  EXPECT_FALSE(find_linear_law(DirectRendering{scene}, T).has_value());
  EXPECT_FALSE(find_linear_law(ProxyRendering{scene, 1e-4, {300, 0.06}}, T).has_value());
  scene.update.period.reset();
  scene.unilateral = true;
  EXPECT_FALSE(find_linear_law(DirectRendering{scene}, T).has_value());
}

}  // namespace
}  // namespace gyrator
