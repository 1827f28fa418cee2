#include "gyrator/two_port/rendering_port.hpp"
#include "gyrator/two_port/stiffest_coupling.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "reference_plants.hpp"

// Case 21 over frequency: direct rendering, proxy and equivalent impedance, table 1 of Kim and Lee
// 2017, statement by statement. What it prints is in docs/twoport.md.

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr double T = 0.03;
constexpr double nyquist_hz = 0.5 / T;

RenderedScene make_table_1(Integration integration = Integration::implicit) {
  RenderedScene scene;
  scene.own = Rendering::proxy;
  scene.contact = SpringDamper{300, 0.06};
  scene.tool = RenderedScene::Tool{1e-4, 0, {300, 0.06}};
  scene.object = RenderedScene::Object{1, {300, 0.06}};
  scene.path.period = scene.path.step = scene.path.tick = T;
  scene.path.integration = integration;
  return scene;
}

RenderingPort make_port(const RenderedScene& scene) {
  return RenderingPort(reference::make_plant(0.022, 0.01), scene);
}

// Every hundredth of a hertz below Nyquist, as the paper's pictures are read.
template <class Function>
void over_frequency(const Function& look) {
  for (int i = 1; 0.01 * i < nyquist_hz; ++i) look(0.01 * i, 2 * pi * 0.01 * i);
}

double distance_from_one(Complex ratio) {
  return std::abs(std::log(std::abs(ratio)));
}

// How far felt and environment are apart, in the paper's order.
struct Distances {
  double equivalent, direct, proxy;
};
Distances find_distances(RenderingPort& port, double omega) {
  const Complex z = *port.environment_impedance(omega);
  const auto distance = [&](Rendering rendering) {
    return distance_from_one(port.at(rendering, omega).transmitted(z) / z);
  };
  return {distance(Rendering::equivalent_impedance), distance(Rendering::direct),
          distance(Rendering::proxy)};
}

TEST(TwoPortCase, statement_1_first_condition_holds_and_is_widest_by_equivalent_impedance) {
  RenderingPort port = make_port(make_table_1());
  double most = 0, least = 1e9;
  over_frequency([&](double, double omega) {
    const double direct = port.at(Rendering::direct, omega).h11.real();
    const double proxy = port.at(Rendering::proxy, omega).h11.real();
    const double equivalent = port.at(Rendering::equivalent_impedance, omega).h11.real();
    EXPECT_NEAR(direct, 0.01, 1e-9);
    EXPECT_GE(proxy, 0.01 - 1e-9);
    most = std::max(most, proxy);
    least = std::min(least, equivalent);
  });
  std::printf("Re h11: direct 0.01, proxy up to %.4f, equivalent impedance from %.3f N.s/m\n", most,
              least);
  EXPECT_LT(most, 0.02);                                // "almost zero" beside
  EXPECT_NEAR(least, 0.01 + 0.06 + 300 * T / 2, 0.01);  // b + c_e + k_e T/2
}

TEST(TwoPortCase, statement_2_second_condition_holds_and_is_widest_by_proxy) {
  RenderingPort port = make_port(make_table_1());
  over_frequency([&](double hertz, double omega) {
    const double direct = port.at(Rendering::direct, omega).h22.real();
    EXPECT_GT(direct, 0) << hertz;
    EXPECT_GT(port.at(Rendering::proxy, omega).h22.real(), direct) << hertz;
    EXPECT_EQ(port.at(Rendering::equivalent_impedance, omega).h22.real(), direct) << hertz;
  });
}

TEST(TwoPortCase, statement_3_third_condition_is_violated_by_direct_and_proxy_everywhere) {
  RenderingPort port = make_port(make_table_1());
  int direct = 0, proxy = 0, all = 0;
  over_frequency([&](double hertz, double omega) {
    const auto third = [&](Rendering rendering) {
      return compute_llewellyn_margins(port.at(rendering, omega)).third;
    };
    ++all;
    if (third(Rendering::direct) < 0) ++direct;
    if (third(Rendering::proxy) < 0) ++proxy;
    EXPECT_GT(third(Rendering::equivalent_impedance), 0) << hertz;
  });
  std::printf("third condition below zero: direct at %d, proxy at %d of %d frequencies\n", direct,
              proxy, all);
  EXPECT_EQ(direct, all);
  EXPECT_EQ(proxy, all);
  for (const auto rendering : {Rendering::direct, Rendering::proxy}) {
    const TwoPortVerdict verdict = port.judge(rendering);
    EXPECT_FALSE(verdict.absolutely_stable);
    ASSERT_EQ(verdict.conditions[2].violated.size(), 1);
    EXPECT_NEAR(verdict.conditions[2].violated[0].to_hz, nyquist_hz, 1e-6);
    std::printf("%s: ratio %.3g at the lowest, third margin %.3f at %.2f Hz\n",
                std::string(name_of(rendering)).c_str(), verdict.ratio,
                verdict.conditions[2].margin, verdict.conditions[2].worst_frequency_hz);
  }
  EXPECT_TRUE(port.judge(Rendering::equivalent_impedance).absolutely_stable);
}

TEST(TwoPortCase, statement_4_it_is_the_hold_that_violates_it) {
  // Without hold, computed elements as they are: 2 b Re(1/Z_c) >= 0.
  RenderedScene scene = make_table_1();
  scene.path.period = 0;
  RenderingPort port = make_port(scene);
  over_frequency([&](double hertz, double omega) {
    EXPECT_GT(compute_llewellyn_margins(port.at(Rendering::direct, omega)).third, 0) << hertz;
  });
}

TEST(TwoPortCase, statement_5_as_the_caption_of_figure_6_prints_it_the_condition_always_fails) {
  RenderedScene scene = make_table_1();
  scene.path.period = 0;
  RenderingPort port = make_port(scene);
  over_frequency([&](double hertz, double omega) {
    const HybridMatrix h = port.at(Rendering::direct, omega);
    const Complex p = h.h12 * h.h21;
    const double printed = 2 * h.h11.real() * h.h22.real() - std::abs(p) + p.real();
    EXPECT_LT(printed, -1) << hertz;  // even without a hold
  });
}

TEST(TwoPortCase,
     statement_6_transparency_has_the_papers_order_up_to_nineteen_twentieths_of_nyquist) {
  RenderingPort port = make_port(make_table_1());
  std::vector<double> edges;  // where it begins or ends to hold
  bool ordered = false;
  over_frequency([&](double hertz, double omega) {
    const Distances d = find_distances(port, omega);
    const bool now = d.equivalent < d.direct && d.direct < d.proxy;
    if (now != ordered) edges.push_back(hertz);
    ordered = now;
  });
  std::printf("order equivalent, direct, proxy changes at");
  for (const double hertz : edges) std::printf(" %.2f", hertz);
  std::printf(" Hz\n|Z_te/Z_e| at Hz: equivalent, direct, proxy\n");
  for (const double hertz : {0.1, 1.0, 2.0, 2.7, 5.0, 10.0, 16.0}) {
    const double omega = 2 * pi * hertz;
    const Complex z = *port.environment_impedance(omega);
    std::printf("%5.1f", hertz);
    for (const auto rendering :
         {Rendering::equivalent_impedance, Rendering::direct, Rendering::proxy})
      std::printf(" %8.4f", std::abs(port.at(rendering, omega).transmitted(z) / z));
    std::printf("\n");
  }
  // From the lowest frequency on, until the proxy passes its own resonance.
  ASSERT_EQ(edges.size(), 2);
  EXPECT_EQ(edges[0], 0.01);
  EXPECT_NEAR(edges[1], 15.80, 0.005);
}

TEST(TwoPortCase, statement_7_what_is_felt_by_equivalent_impedance_is_the_sum) {
  RenderingPort port = make_port(make_table_1());
  over_frequency([&](double hertz, double omega) {
    const Complex z = *port.environment_impedance(omega);
    const Complex felt = port.at(Rendering::equivalent_impedance, omega).transmitted(z);
    const Complex sum = Complex(0.01, 0.022 * omega) + z;  // (K15)
    EXPECT_NEAR(std::abs(felt / sum - 1.0), 0, 1e-9) << hertz;
  });
}

TEST(TwoPortCase, statement_8_always_satisfied_holds_for_backward_differences_only) {
  EXPECT_TRUE(make_port(make_table_1()).judge(Rendering::equivalent_impedance).absolutely_stable);
  // Explicit steps: Re Z_c = c - k T/2 = -4.44 N.s/m, at every frequency.
  RenderingPort explicit_port = make_port(make_table_1(Integration::explicit_euler));
  const TwoPortVerdict verdict = explicit_port.judge(Rendering::equivalent_impedance);
  EXPECT_FALSE(verdict.conditions[0].holds);
  EXPECT_FALSE(verdict.conditions[1].holds);
  over_frequency([&](double hertz, double omega) {
    const HybridMatrix h = explicit_port.at(Rendering::equivalent_impedance, omega);
    EXPECT_LT(h.h22.real(), 0) << hertz;
  });
}

TEST(TwoPortCase, statement_9_the_tool_widens_the_first_condition_and_the_second_below_11_hz) {
  RenderedScene light = make_table_1();
  light.tool->inertia = 1e-9;
  RenderingPort light_port = make_port(light), port = make_port(make_table_1());
  std::vector<double> narrower;
  over_frequency([&](double hertz, double omega) {
    const HybridMatrix without = light_port.at(Rendering::proxy, omega);
    const HybridMatrix with = port.at(Rendering::proxy, omega);
    EXPECT_GE(with.h11.real(), without.h11.real() - 1e-15) << hertz;  // equal at Nyquist
    if (with.h22.real() < without.h22.real()) narrower.push_back(hertz);
  });
  ASSERT_FALSE(narrower.empty());
  EXPECT_NEAR(narrower.front(), 11.07, 0.005);
  EXPECT_NEAR(narrower.back(), 16.66, 0.005);
}

TEST(TwoPortCase, statement_11_an_explicit_tool_violates_the_first_condition_only_if_it_is_heavy) {
  const auto violated_by = [&](double mass) {
    RenderedScene scene = make_table_1(Integration::explicit_euler);
    scene.tool->inertia = mass;
    RenderingPort port = make_port(scene);
    std::vector<double> violated;
    over_frequency([&](double hertz, double omega) {
      const HybridMatrix h = port.at(Rendering::proxy, omega);
      if (h.h11.real() < 0) violated.push_back(hertz);
      EXPECT_LT(h.h22.real(), 0) << hertz;  // by springs of explicit steps, whatever the tool
    });
    return violated;
  };
  EXPECT_TRUE(violated_by(1e-4).empty());  // table 1: b = 0.01 N.s/m is enough
  const auto heavy = violated_by(0.01);
  ASSERT_FALSE(heavy.empty());
  EXPECT_NEAR(heavy.front(), 5.46, 0.005);
  EXPECT_NEAR(heavy.back(), 15.62, 0.005);
}

TEST(TwoPortCase, statement_10_a_stiffer_contact_is_felt_truer_and_narrows_the_second_condition) {
  double last_h22 = 1e9, last_distance = 1e9;
  const double omega = 2 * pi * 0.3;
  for (const double stiffness : {30.0, 300.0, 3000.0, 30000.0}) {
    RenderedScene scene = make_table_1();
    scene.contact->stiffness = stiffness;
    RenderingPort port = make_port(scene);
    const double h22 = port.at(Rendering::direct, omega).h22.real();
    const double distance = find_distances(port, omega).direct;
    EXPECT_LT(h22, last_h22);
    EXPECT_LT(distance, last_distance);
    last_h22 = h22;
    last_distance = distance;
  }
}

TEST(TwoPortCase, the_stiffest_coupling_of_table_1_is_far_below_its_own) {
  const Device device = reference::make_plant(0.022, 0.01);
  for (const Sensing sensing : {Sensing::velocity, Sensing::position}) {
    ComputedPath path = make_table_1().path;
    path.sensing = sensing;
    const StiffestCoupling coupling(device, path);
    // Its damper alone, 0.06 N.s/m, is more than the device's 0.01 N.s/m allows: pi b, 1.9 b.
    EXPECT_FALSE(coupling.find(0.06).feasible);
    const BestCoupling best = coupling.find_best().value();
    std::printf("%s sensed: best %.4f N/m at %.5f N.s/m, undamped %.4f N/m\n",
                std::string(name_of(sensing)).c_str(), best.limit.stiffness, best.damping,
                coupling.find(0).stiffness);
    EXPECT_LT(best.limit.stiffness, 300.0 / 100);
    const double undamped = sensing == Sensing::velocity ? 2 * pi * 0.01 / T : 2 * 0.01 / T;
    EXPECT_NEAR(coupling.find(0).stiffness / undamped, 1, 1e-6);
  }
}

}  // namespace
}  // namespace gyrator
