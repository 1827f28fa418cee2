#include "gyrator/controllers/controller.hpp"
#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "reference_plants.hpp"

// Case 21 in the time domain, behind an update of 30 Hz: direct rendering, proxy and equivalent
// impedance of a deformable object, table 1 of Kim and Lee 2017. The tables that it prints are
// those of docs/controllers/deformable.md; two_port_cases_test has the paper's own view, over
// frequency.

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr double m_d = 0.022, b = 0.01;           // device
constexpr double m_t = 1e-4;                      // tool
constexpr double c_vc = 0.06, k_vc = 300;         // coupling, and contact
constexpr double m_e = 1, c_e = 0.06, k_e = 300;  // object
constexpr SpringDamper connection{3000, 1};       // of the equivalent impedance's copy
const Rational fast(1, 1000);

struct Rendering {
  std::string name;
  Law law;
};

// The three at an update's period; the proxy's tool implicit (semi-implicit it needs 53 substeps).
std::vector<Rendering> make_renderings(const Rational& period, bool unilateral) {
  DeformableScene scene;
  scene.object = {m_e, {k_e, c_e}, 0};
  scene.contact = {k_vc, c_vc};
  scene.unilateral = unilateral;
  scene.update.period = period;
  DeformableScene implicit = scene;
  implicit.integration = Integration::implicit;
  DeformableScene stiff = scene;
  stiff.contact = connection;
  return {{"direct", DirectRendering{scene}},
          {"proxy", ProxyRendering{implicit, m_t, {k_vc, c_vc}}},
          {"equivalent", EquivalentImpedance{stiff}},
          {"equivalent, soft contact", EquivalentImpedance{scene}}};
}

Complex device_impedance(Complex s) {
  return m_d * s + b;
}
Complex object_impedance(Complex s) {
  return m_e * s + c_e + k_e / s;
}

double distance_from_one(Complex ratio) {
  return std::abs(std::log(std::abs(ratio)));
}

// ---- Time domain ------------------------------------------------------------------------------

// Impedance felt at the port while a hand of infinite strength swings it: Z_m and the fundamental
// of the held command over the velocity.
Complex measure_impedance(const Law& law, double hertz) {
  const double T = fast.to_double();
  RunningController running(Controller(law, {}), T);
  const Complex s(0, 2 * pi * hertz);
  // The object rings for 2 m_e/c_e = 33 s: wait for ten times that. Whole periods of hand and
  // update: frequencies are multiples of 0.1 Hz.
  const long settle = 330'000, window = 100'000;
  Complex sum = 0;
  for (long k = 0; k < settle + window; ++k) {
    const double t = T * static_cast<double>(k);
    const double command = running.step(1e-3 * std::cos(s.imag() * t));
    if (k >= settle) sum += -command * std::exp(-s * t);
  }
  const Complex hold = (1.0 - std::exp(-s * T)) / (s * T);
  const Complex effort = 2.0 * sum / static_cast<double>(window) * hold;
  return device_impedance(s) + effort / (1e-3 * s);
}

TEST(EquivalentImpedanceCase, transparency_measured_in_the_time_domain_has_the_papers_order) {
  const std::vector<double> frequencies{0.3, 1, 2, 5, 10};
  for (const Rational& period : {Rational(1, 30), Rational(3, 100)}) {
    const auto renderings = make_renderings(period, false);
    std::printf("|Z_te/Z_e|, update every %s s\n%-26s", period.to_string().c_str(), "");
    for (const double f : frequencies) std::printf("%9.1f Hz", f);
    std::printf("\n");
    std::vector<std::vector<Complex>> ratio(renderings.size());
    for (std::size_t i = 0; i < renderings.size(); ++i) {
      std::printf("%-26s", renderings[i].name.c_str());
      for (const double f : frequencies) {
        ratio[i].push_back(measure_impedance(renderings[i].law, f) /
                           object_impedance({0, 2 * pi * f}));
        std::printf("%12.3f", std::abs(ratio[i].back()));
      }
      std::printf("\n");
    }
    // Well below the object's own frequency, 2.76 Hz, where a spring is felt.
    for (std::size_t f = 0; f < 2; ++f) {
      const double direct = distance_from_one(ratio[0][f]);
      const double proxy = distance_from_one(ratio[1][f]);
      const double equivalent = distance_from_one(ratio[2][f]);
      EXPECT_LT(equivalent, direct) << frequencies[f];
      EXPECT_LT(direct, proxy) << frequencies[f];
    }
    // At rest the springs in series: 1/2, 1/3, 10/11; at 0.3 Hz within 2 % of it.
    EXPECT_NEAR(std::abs(ratio[0][0]), 0.5, 0.02);
    EXPECT_NEAR(std::abs(ratio[1][0]), 1.0 / 3, 0.02);
    EXPECT_NEAR(std::abs(ratio[2][0]), 10.0 / 11, 0.02);
  }
}

struct Pressed {
  std::string outcome;
  double made = 0;  // most energy that the environment has given so far beyond what it took [J]
};

// A hand of 0.2 kg and 100 N/m pushes with 2 N into the object, at rest 1 cm before it.
Pressed press(const Law& law, double hand_damping, const Rational& duration) {
  const Device device = reference::make_plant(m_d, b);
  const Plant plant =
      build_plant(build_device_network(device, MassSpringDamper{0.2, hand_damping, 100, {}}));
  SimulationOptions options;
  options.duration = duration;
  options.external_effort = 2;
  options.initial_position = -0.01;
  const TimeRun run = simulate(plant, {}, Controller(law, {}), {fast, 0}, options);
  Pressed result;
  result.outcome = std::string(name_of(run.classification.outcome));
  for (const double energy : run.trace.column("energy_source"))
    result.made = std::max(result.made, energy);
  return result;
}

// The damping of the hand [N.s/m] from which on pressing comes to rest, to 5 %: from above, since
// islands of rest lie below it.
double find_least_damping(const Law& law) {
  constexpr double most = 20, step = 1.05;
  double damping = most;
  while (damping > 1e-3 && press(law, damping, 30).outcome == "settles") damping /= step;
  return damping * step;
}

TEST(EquivalentImpedanceCase, stability_measured_in_the_time_domain) {
  for (const Rational& period : {Rational(1, 30), Rational(3, 100)}) {
    std::printf("pressing with 2 N, update every %s s\n%-26s %14s %14s %20s\n",
                period.to_string().c_str(), "", "1 N.s/m", "energy made", "settles from");
    std::vector<double> least;
    std::vector<Pressed> pressed;
    for (const auto& rendering : make_renderings(period, true)) {
      pressed.push_back(press(rendering.law, 1, 30));
      least.push_back(find_least_damping(rendering.law));
      std::printf("%-26s %14s %11.4g J %14.3g N.s/m\n", rendering.name.c_str(),
                  pressed.back().outcome.c_str(), pressed.back().made, least.back());
    }
    EXPECT_NE(pressed[0].outcome, "settles");
    EXPECT_EQ(pressed[2].outcome, "settles");
    EXPECT_LT(least[2], least[1]);
    EXPECT_LT(least[1], least[0]);
    // The passive copy makes no more than its contact at 1 kHz does; held efforts make it for ever.
    EXPECT_LT(pressed[2].made, 1e-2 * pressed[0].made);
  }
}

TEST(EquivalentImpedanceCase, the_papers_tool_cannot_be_simulated_as_it_stands) {
  // Semi-implicit at 30 Hz without substeps: the tool's own mode grows by a factor of thousands
  // every update, whatever the hand does.
  for (const Rational& period : {Rational(1, 30), Rational(3, 100)}) {
    DeformableScene scene;
    scene.object = {m_e, {k_e, c_e}, 0};
    scene.contact = {k_vc, c_vc};
    scene.update.period = period;
    EXPECT_EQ(press(ProxyRendering{scene, m_t, {k_vc, c_vc}}, 10, 10).outcome, "diverges");
    scene.substeps = 53;
    EXPECT_EQ(press(ProxyRendering{scene, m_t, {k_vc, c_vc}}, 10, 10).outcome, "settles");
  }
}

}  // namespace
}  // namespace gyrator
