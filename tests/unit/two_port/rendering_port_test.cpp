#include "gyrator/two_port/rendering_port.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"
#include "gyrator/two_port/stiffest_coupling.hpp"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "support/mentions.hpp"
#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

constexpr double T = 0.03;

RenderedScene make_scene(Integration integration = Integration::implicit) {
  RenderedScene scene;
  scene.own = Rendering::proxy;
  scene.contact = SpringDamper{300, 0.06};
  scene.tool = RenderedScene::Tool{1e-4, 0.01, {200, 0.05}};
  scene.object = RenderedScene::Object{1, {310, 0.07}};
  scene.path.period = scene.path.step = scene.path.tick = T;
  scene.path.integration = integration;
  return scene;
}

void expect_equal(const HybridMatrix& a, const HybridMatrix& b) {
  constexpr double rounding = 1e-12;
  EXPECT_NEAR(std::abs(a.h11 - b.h11), 0, rounding * std::abs(b.h11));
  EXPECT_NEAR(std::abs(a.h12 - b.h12), 0, rounding);
  EXPECT_NEAR(std::abs(a.h21 - b.h21), 0, rounding);
  EXPECT_NEAR(std::abs(a.h22 - b.h22), 0, rounding * std::abs(b.h22));
}

TEST(RenderingPort, has_the_papers_matrices_on_a_mass_and_damper) {
  RenderedScene scene = make_scene();
  scene.passivity_damping = 0.4;
  RenderingPort port(make_point_mass(0.022, 0.01).device, scene);
  for (const double omega : {0.3, 17.0, 80.0}) {
    const Complex s(0, omega), z = std::exp(s * T), D = (z - 1.0) / (T * z);
    const Complex G = (1.0 - std::exp(-s * T)) / (s * T);
    const Complex Z_m = 0.022 * s + 0.01, Z_c = 0.06 + 300.0 / D, Z_vc = 0.05 + 200.0 / D;
    const Complex Z_t = 1e-4 * D + 0.01, Z_e = 1.0 * D + 0.07 + 310.0 / D;
    expect_equal(port.at(Rendering::direct, omega), {Z_m + 0.4 * G, G, -1, 1.0 / Z_c});
    const Complex share = Z_vc / (Z_vc + Z_t);
    expect_equal(port.at(Rendering::proxy, omega),
                 {Z_m + G * share * Z_t, G * share, -share, 1.0 / Z_c + 1.0 / (Z_vc + Z_t)});
    expect_equal(port.at(Rendering::equivalent_impedance, omega), {Z_m + Z_e, 0, -1, 1.0 / Z_c});
    EXPECT_NEAR(std::abs(*port.environment_impedance(omega) / Z_e - 1.0), 0, 1e-12);
  }
}

TEST(RenderingPort, sends_the_effort_through_the_devices_actuation_path_and_delay) {
  const KnownDevice motor = make_rc_motor();
  RenderedScene scene = make_scene();
  scene.path.delay = 0.004;
  RenderingPort port(motor.device, scene);
  for (const double omega : {0.3, 17.0, 80.0}) {
    const Complex s(0, omega);
    const PortForm form = motor.at(s);
    const Complex G = (1.0 - std::exp(-s * T)) / (s * T);
    const HybridMatrix h = port.at(Rendering::direct, omega);
    EXPECT_NEAR(std::abs(h.h11 / form.impedance - 1.0), 0, 1e-9);
    EXPECT_NEAR(std::abs(h.h12 / (form.actuation * G * std::exp(-0.004 * s)) - 1.0), 0, 1e-9);
    // The equivalent impedance acts beside the device: through A, but neither held nor late.
    const Complex felt = port.at(Rendering::equivalent_impedance, omega).h11;
    const Complex expected = form.impedance + form.actuation * *port.environment_impedance(omega);
    EXPECT_NEAR(std::abs(felt / expected - 1.0), 0, 1e-9);
  }
}

TEST(RenderingPort, solves_the_loop_that_a_sensor_behind_a_transmission_closes) {
  Device device = make_point_mass(0.04, 0.8).device;
  device.mechanics.transmission = Transmission{4000, 0.3, 0.01};
  device.sensor = SensorLocation::motor;
  RenderedScene scene = make_scene();
  scene.path.sensing = Sensing::position;
  RenderingPort port(device, scene);
  PortModel model(device);
  for (const double omega : {0.3, 17.0, 80.0}) {
    // f_h, u, v_s, w, F and v_e as unknowns, straight from (port-1) and the tool's equations.
    const PortResponse r = model.at(omega);
    const Complex s(0, omega), z = std::exp(s * T), D = (z - 1.0) / (T * z);
    const Complex G = (1.0 - std::exp(-s * T)) / (s * T);
    const Complex Z_c = 0.06 + 300.0 / D, Z_vc = 0.05 + 200.0 / D, Z_t = 1e-4 * D + 0.01;
    const HybridMatrix h = port.at(Rendering::proxy, omega);
    const Complex v_h(0.7, -0.2), f_e(0.1, 0.9);
    // F = Z_vc (w - v_t), Z_t v_t = F - f_e, v_e = v_t - f_e/Z_c, w = G (S v_h - M G F)
    Eigen::Matrix3cd equations;  // unknown F, v_t, w
    equations << 1.0, Z_vc, -Z_vc, -1.0, Z_t, 0.0, G * r.blocked_motion * G, 0.0, 1.0;
    const Eigen::Vector3cd given(0.0, -f_e, G * r.sensor_path * v_h);
    const Eigen::Vector3cd x = equations.partialPivLu().solve(given);
    const Complex f_h = r.impedance * v_h + r.actuation * G * x(0);
    const Complex v_e = x(1) - f_e / Z_c;
    EXPECT_GT(std::abs(r.blocked_motion), 1e-6);  // there is a loop
    EXPECT_NEAR(std::abs((h.h11 * v_h + h.h12 * f_e) / f_h - 1.0), 0, 1e-9);
    EXPECT_NEAR(std::abs((h.h21 * v_h + h.h22 * f_e) / -v_e - 1.0), 0, 1e-9);
  }
}

TEST(RenderingPort, of_a_virtual_coupling_ends_at_its_tool) {
  VirtualCoupling law;
  law.coupling = {300, 0.2};
  law.tool_inertia = 0.01;
  law.wall = ToolWall{{900, 5}};
  const RenderedScene scene = make_rendered_scene(law, {});
  EXPECT_EQ(scene.own, Rendering::proxy);
  RenderingPort port(make_p3().device, scene);
  const double omega = 40, step = 1e-3;
  const VirtualElements elements(omega, step, Integration::semi_implicit);
  const Complex tied = elements.link({300, 0.2}) + elements.mass(0.01);
  EXPECT_NEAR(std::abs(port.at(Rendering::proxy, omega).h22 * tied - 1.0), 0, 1e-12);
  EXPECT_NEAR(std::abs(port.at(Rendering::direct, omega).h22 * elements.link({300, 0.2}) - 1.0), 0,
              1e-12);
  EXPECT_NEAR(std::abs(*port.environment_impedance(omega) / elements.link({900, 5}) - 1.0), 0,
              1e-12);
}

TEST(RenderingPort, knows_how_late_a_slow_update_is) {
  DirectRendering law;
  law.scene.update.period = Rational(3, 100);
  const Sampling sampling{Rational(1, 1000), Rational(1, 2000)};
  EXPECT_DOUBLE_EQ(make_rendered_scene(law, sampling).path.delay, 1.5e-3);
  EXPECT_DOUBLE_EQ(make_rendered_scene(law, sampling).path.period, 0.03);
  law.scene.update.delay = Rational(23, 10000);  // 2.3 ms: the third tick after
  EXPECT_DOUBLE_EQ(make_rendered_scene(law, sampling).path.delay, 3.5e-3);
  law.scene.update = {};
  EXPECT_DOUBLE_EQ(make_rendered_scene(law, sampling).path.delay, 0.5e-3);
}

TEST(RenderingPort, of_steps_that_diverge_is_not_absolutely_stable) {
  RenderedScene scene = make_scene();
  scene.contact = SpringDamper{0.1, 0.06};
  scene.tool->coupling = {0.1, 0.06};
  const Device device = make_point_mass(0.022, 1).device;
  EXPECT_TRUE(RenderingPort(device, scene).judge(Rendering::proxy).absolutely_stable);
  scene.path.integration = Integration::semi_implicit;  // the tool's damper: c T > 2 m
  const TwoPortVerdict verdict = RenderingPort(device, scene).judge(Rendering::proxy);
  EXPECT_GT(verdict.computed_spectral_radius, 1);
  EXPECT_FALSE(verdict.absolutely_stable);
  for (const ConditionResult& condition : verdict.conditions) EXPECT_TRUE(condition.holds);
}

template <class Function>
std::string message_of(const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing thrown";
}

TEST(RenderingPort, refuses_what_has_no_environment_and_what_is_missing) {
  const auto make = [](const Controller& controller) {
    return message_of([&] { make_rendered_scene(controller, {}); });
  };
  for (const Controller& controller : {Controller(NoController{}), Controller(VirtualWall{1, 0})}) {
    EXPECT_TRUE(mentions(make(controller), "controller/kind"));
    EXPECT_TRUE(mentions(make(controller), "virtual_coupling"));
  }
  VirtualCoupling slow;
  slow.update.period = Rational(1, 60);
  EXPECT_TRUE(mentions(make(slow), "controller/update"));
  RenderedScene scene = make_scene();
  scene.tool.reset();
  scene.object.reset();
  RenderingPort port(make_p3().device, scene);
  EXPECT_TRUE(mentions(message_of([&] { port.at(Rendering::proxy, 1); }), "controller/tool"));
  EXPECT_TRUE(mentions(message_of([&] { port.judge(Rendering::equivalent_impedance); }),
                       "controller/environment"));
  EXPECT_EQ(port.available(), std::vector<Rendering>{Rendering::direct});
}

TEST(RenderingPort, lacks_exactly_the_damping_that_makes_it_absolutely_stable) {
  for (const Rendering rendering : {Rendering::direct, Rendering::proxy}) {
    const RenderedScene scene = make_scene();
    const double b = 0.01;
    const double missing =
        -RenderingPort(make_point_mass(0.022, b).device, scene).judge(rendering).felt;
    ASSERT_GT(missing, 0);
    const auto holds = [&](double added) {
      const Device device = make_point_mass(0.022, b + added).device;
      return RenderingPort(device, scene).judge(rendering).absolutely_stable;
    };
    EXPECT_FALSE(holds(0.99 * missing));
    EXPECT_TRUE(holds(1.01 * missing));
  }
}

// ---- The stiffest coupling --------------------------------------------------------------------

bool holds_as_direct(const Device& device, const ComputedPath& path, const SpringDamper& coupling) {
  RenderedScene scene;
  scene.contact = coupling;
  scene.path = path;
  const TwoPortVerdict verdict = RenderingPort(device, scene).judge(Rendering::direct);
  return verdict.conditions[0].holds && verdict.conditions[1].holds && verdict.conditions[2].holds;
}

TEST(StiffestCoupling, is_the_low_frequency_limit_on_a_mass_and_damper_or_the_one_at_nyquist) {
  const double b = 0.8, period = 1e-3;
  for (const double delay : {0.0, 0.4e-3, 1e-3}) {
    for (const Sensing sensing : {Sensing::velocity, Sensing::position}) {
      ComputedPath path;
      path.delay = delay;
      path.sensing = sensing;
      const StiffestCoupling coupling(make_p3().device, path);
      const double t = delay + (sensing == Sensing::position ? period : period / 2);
      for (const double c : {0.0, 0.05}) {
        double k = (b * period + std::sqrt(b * b * period * period + 4 * b * c * t * t)) / (t * t);
        if (t == period / 2) {
          EXPECT_GT(k, 2 * (pi * b - c) / period);
          k = 2 * (pi * b - c) / period;
        }
        // Judged from w T = 1e-5 on; the limit is approached with its square.
        EXPECT_NEAR(coupling.find(c).stiffness / k, 1, 1e-6) << delay << " " << c;
      }
    }
  }
}

TEST(StiffestCoupling, with_the_position_sensed_is_the_wall_that_b_over_half_KT_allows) {
  ComputedPath path;
  path.sensing = Sensing::position;
  EXPECT_NEAR(StiffestCoupling(make_p3().device, path).find(0).stiffness, 2 * 0.8 / 1e-3, 1e-3);
}

TEST(StiffestCoupling, is_no_stiffer_than_the_wall_that_the_exact_disk_allows) {
  // A rigid environment makes a wall of the coupling; every other one may only ask for more. Where
  // the command lags through the RC branch, that is what bounds both.
  const double c = 1.5e-4;
  ComputedPath path;
  path.sensing = Sensing::position;
  for (const auto& [ideal, least_share] : {std::pair{false, 0.9}, std::pair{true, 0.7}}) {
    const Device device = make_rc_motor({}, ideal).device;
    StiffnessLimits limits(device, {}, DifferenceEstimator{}, FreeOperator{});
    const double wall = limits.find(Criterion::exact_disk, c).stiffness;
    const double coupling = StiffestCoupling(device, path).find(c).stiffness;
    EXPECT_LT(coupling, wall);
    EXPECT_GT(coupling, least_share * wall);
  }
}

TEST(StiffestCoupling, stands_on_both_sides_of_its_limit_on_any_device) {
  Device geared = make_p3().device;
  geared.mechanics.transmission = Transmission{4e5, 3, 0.01};
  geared.sensor = SensorLocation::motor;
  Device soft = geared;  // the sensor sees what the command does behind the transmission
  soft.mechanics.transmission = Transmission{1000, 1, 0.01};
  for (const Device& device : {make_p3().device, make_rc_motor().device, geared, soft}) {
    for (const auto scheme : {Integration::implicit, Integration::explicit_euler}) {
      for (const Sensing sensing : {Sensing::velocity, Sensing::position}) {
        ComputedPath path;
        path.delay = 0.3e-3;
        path.integration = scheme;
        path.sensing = sensing;
        const StiffestCoupling coupling(device, path);
        const double c = 0.2 * coupling.find_best().value().damping;
        const CouplingLimit limit = coupling.find(c);
        ASSERT_TRUE(limit.feasible);
        ASSERT_TRUE(std::isfinite(limit.stiffness));
        EXPECT_TRUE(holds_as_direct(device, path, {0.99 * limit.stiffness, c}));
        EXPECT_FALSE(holds_as_direct(device, path, {1.01 * limit.stiffness, c}));
      }
    }
  }
}

TEST(StiffestCoupling, has_no_stiffness_beyond_the_largest_damper_and_is_best_below) {
  ComputedPath path;
  path.sensing = Sensing::position;
  const StiffestCoupling coupling(make_p3().device, path);
  const BestCoupling best = coupling.find_best().value();
  EXPECT_GT(best.damping, 0);
  for (const double factor : {0.5, 0.9, 1.1, 1.5})
    EXPECT_LT(coupling.find(factor * best.damping).stiffness, best.limit.stiffness) << factor;
  // p = -G^2: R = (sin x)^4/(x^2 b) with x = w T/2, largest where tan x = 2 x.
  const double x = 1.1655611852072;
  const double most = 0.8 * x * x / std::pow(std::sin(x), 4);
  EXPECT_TRUE(coupling.find(0.999 * most).feasible);
  EXPECT_FALSE(coupling.find(1.001 * most).feasible);
  // With the velocity sensed R = sin x (1 - cos x)/(2 x b), largest at Nyquist: 1/(pi b).
  const StiffestCoupling sooner(make_p3().device, {});
  EXPECT_TRUE(sooner.find(0.999 * pi * 0.8).feasible);
  EXPECT_FALSE(sooner.find(1.001 * pi * 0.8).feasible);
  EXPECT_THROW(coupling.find(-1), Error);
}

TEST(StiffestCoupling, exists_on_no_device_without_damping) {
  const StiffestCoupling coupling(make_point_mass(0.04, 0).device, {});
  EXPECT_FALSE(coupling.find(0.1).feasible);
  EXPECT_FALSE(coupling.find_best().has_value());
}

TEST(StiffestProxyCoupling, stands_on_both_sides_of_its_limit) {
  RenderedScene scene = make_scene();
  const Device device = make_point_mass(0.022, 0.3).device;
  const double k = find_stiffest_proxy_coupling(device, scene).value();
  EXPECT_GT(k, 0);
  const auto holds = [&](double stiffness) {
    RenderedScene varied = scene;
    varied.tool->coupling.stiffness = stiffness;
    return RenderingPort(device, varied).judge(Rendering::proxy).absolutely_stable;
  };
  for (const double factor : {0.1, 0.5, 0.99}) EXPECT_TRUE(holds(factor * k)) << factor;
  EXPECT_FALSE(holds(1.01 * k));
  scene.tool.reset();
  EXPECT_FALSE(find_stiffest_proxy_coupling(device, scene).has_value());
}

}  // namespace
}  // namespace gyrator
