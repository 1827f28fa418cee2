#include "gyrator/passivity/impedance_envelope.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

const Rational T(1, 1000);
const std::vector<double> frequencies{0.1, 1, 4, 12, 30, 70, 150, 300, 420, 499.9};

// Everything about a device's envelope.
struct Bench {
  StiffnessLimits limits;
  DisplayedImpedance displayed;
  std::vector<WallChoice> choices;

  Bench(const Device& device, const Sampling& sampling, Criterion criterion,
        const Controller& controller = VirtualWall{})
      : limits(device, sampling, controller, FreeOperator{}), displayed(device, sampling) {
    const LawFamily family(controller, sampling.period.to_double());
    choices.push_back({family, trace_passive_walls(limits, family, criterion)});
  }

  std::vector<EnvelopePoint> compute(const std::vector<double>& hertz = frequencies) {
    return compute_impedance_envelope(displayed, choices, hertz);
  }

  Complex law_at(const WallPoint& wall, double hertz) const {
    return choices.front()
        .family.at(choices.front().family.prepare(2 * pi * hertz), wall.damping)
        .at(wall.stiffness);
  }

  double peak() const {
    double peak = 0;
    for (const auto& corner : choices.front().walls.outline)
      peak = std::max(peak, corner.stiffness);
    return peak;
  }
};

struct Case {
  std::string name;
  Device device;
  Sampling sampling;
  Controller controller = VirtualWall{};
};

std::vector<Case> make_cases() {
  const VirtualWall filtered{.velocity = FilteredDifferenceEstimator{40}};
  return {{"P3", make_p3().device, {T, 0}},
          {"P3, late", make_p3().device, {T, Rational(17, 10000)}},
          {"rc motor", make_rc_motor().device, {T, 0}},
          {"rc motor, filtered velocity", make_rc_motor().device, {T, 0}, filtered},
          {"rc motor, late", make_rc_motor().device, {T, Rational(7, 10000)}}};
}

TEST(ImpedanceEnvelope, of_a_mass_and_damper_is_that_of_the_triangle_of_passive_walls) {
  // spring_damper: K < 2 (b - |B|)/T, corners (0, -b), (0, b), (2 b/T, 0).
  constexpr double m = 0.04, b = 0.8;
  const double period = T.to_double();
  Bench bench(make_point_mass(m, b).device, {T, 0}, Criterion::spring_damper);
  EXPECT_NEAR(bench.choices.front().walls.area(), b * b / period, 1e-4 * b * b / period);
  const auto envelope = bench.compute();
  for (const EnvelopePoint& point : envelope) {
    const Complex s(0, 2 * pi * point.frequency_hz);
    const Complex z = std::exp(s * period);
    const Complex hold = (1.0 - 1.0 / z) / (s * s * period);
    double highest = 0;
    double lowest = INFINITY;
    constexpr int steps = 400;
    for (int i = 0; i <= steps; ++i) {
      const double B = b * (2.0 * i / steps - 1);
      for (int j = 0; j <= steps; ++j) {
        const double K = 2 * (b - std::abs(B)) / period * j / steps;
        const double size = std::abs(m * s + b + hold * (K + B * (1.0 - 1.0 / z) / period));
        highest = std::max(highest, size);
        lowest = std::min(lowest, size);
      }
    }
    // The range of B is found to 2^-18, the corner to outline_tolerance; a wall of the lattice is
    // at most 2 b/T/steps from the best one, which moves Z by the hold times that.
    const double lattice = 2 * b / period / steps * std::abs(hold);
    EXPECT_NEAR(point.highest.magnitude, highest, 2e-3 * highest) << point.frequency_hz;
    EXPECT_LE(point.lowest.magnitude, lowest + 1e-5 * highest) << point.frequency_hz;
    EXPECT_GE(point.lowest.magnitude, lowest - lattice - 1e-3 * point.highest.magnitude);
    EXPECT_NEAR(point.bare, std::abs(m * s + b), 1e-12 * point.bare);
  }
}

TEST(ImpedanceEnvelope, holds_every_passive_wall_inside_the_region_too) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  for (const Case& c : make_cases()) {
    Bench bench(c.device, c.sampling, Criterion::exact_disk, c.controller);
    const auto& outline = bench.choices.front().walls.outline;
    const double low = outline.front().damping;
    double high = low;
    for (const auto& corner : outline) high = std::max(high, corner.damping);
    const auto envelope = bench.compute();
    int near_the_top = 0;
    for (int i = 0; i < 15; ++i) {
      const double damping = low + (high - low) * share(random);
      const StiffnessLimit limit = bench.limits.find(Criterion::exact_disk, damping);
      ASSERT_TRUE(limit.feasible) << c.name << damping;
      const WallPoint wall{std::sqrt(share(random)) * limit.stiffness, damping};
      for (const EnvelopePoint& point : envelope) {
        const DisplayedLoop loop = bench.displayed.at(2 * pi * point.frequency_hz);
        const Complex law = bench.law_at(wall, point.frequency_hz);
        const double size = std::abs(loop.displayed(law));
        // The polygon's sides are that far from the boundary in K, and dZ/dK is this.
        const double slack = outline_tolerance * bench.peak() * std::abs(loop.path) /
                             std::norm(1.0 + law * loop.blocked);
        EXPECT_LT(size, point.highest.magnitude + 2 * slack) << c.name << point.frequency_hz;
        EXPECT_GT(size, point.lowest.magnitude - 2 * slack) << c.name << point.frequency_hz;
        if (size > 0.8 * point.highest.magnitude) ++near_the_top;
      }
    }
    EXPECT_GT(near_the_top, 3) << c.name;  // the sample is no idle one
  }
}

TEST(ImpedanceEnvelope, extremes_are_attained_by_the_passive_wall_that_is_named) {
  for (const Case& c : make_cases()) {
    Bench bench(c.device, c.sampling, Criterion::exact_disk, c.controller);
    for (const EnvelopePoint& point : bench.compute()) {
      for (const auto& extreme : {point.highest, point.lowest}) {
        const DisplayedLoop loop = bench.displayed.at(2 * pi * point.frequency_hz);
        const double size =
            std::abs(loop.displayed(bench.law_at(extreme.wall, point.frequency_hz)));
        EXPECT_NEAR(extreme.magnitude, size, 1e-9 * size) << c.name;
        const StiffnessLimit limit = bench.limits.find(Criterion::exact_disk, extreme.wall.damping);
        EXPECT_LE(extreme.wall.stiffness, limit.stiffness + outline_tolerance * bench.peak())
            << c.name << point.frequency_hz;
      }
      EXPECT_LE(point.lowest.magnitude, point.bare * (1 + 1e-12));
      EXPECT_GE(point.highest.magnitude, point.bare * (1 - 1e-12));
    }
  }
}

TEST(ImpedanceEnvelope, holds_every_wall_of_a_region_where_the_sensor_is_not_at_the_port) {
  // There the held loop m makes |Z_cl|^2 a ratio of two quadratics along a side. A region that is
  // small enough to be passive, without a search for its border.
  const Device device = make_compliant(2e-5, 2e-4, {0.8, 1e-4, 1e-5}, SensorLocation::motor).device;
  const LawFamily family{Controller(VirtualWall{}), T.to_double()};
  const PassiveWalls walls{{{0, -5e-5}, {0, 1e-4}, {0.02, 1e-4}, {0.02, -5e-5}}};
  DisplayedImpedance displayed(device, {T, Rational(4, 10000)});
  const auto envelope = compute_impedance_envelope(displayed, {{family, walls}}, frequencies);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> share(0, 1);
  for (const EnvelopePoint& point : envelope) {
    const double omega = 2 * pi * point.frequency_hz;
    const DisplayedLoop loop = displayed.at(omega);
    EXPECT_GT(std::abs(loop.blocked), 0);
    double highest = 0;
    double lowest = INFINITY;
    for (int i = 0; i < 4000; ++i) {
      const MobiusLaw law = family.at(family.prepare(omega), -5e-5 + 1.5e-4 * share(random));
      const double size = std::abs(loop.displayed(law.at(0.02 * share(random))));
      highest = std::max(highest, size);
      lowest = std::min(lowest, size);
    }
    EXPECT_LE(highest, point.highest.magnitude * (1 + 1e-12)) << point.frequency_hz;
    EXPECT_GE(lowest, point.lowest.magnitude * (1 - 1e-12)) << point.frequency_hz;
    // 4000 walls come within a fiftieth of each side of every extreme.
    const double spread = point.highest.magnitude - point.lowest.magnitude;
    EXPECT_GT(highest, point.highest.magnitude - spread / 5) << point.frequency_hz;
    EXPECT_LT(lowest, point.lowest.magnitude + spread / 5) << point.frequency_hz;
  }
}

TEST(ImpedanceEnvelope, of_two_equal_devices_in_parallel_is_doubled_and_no_wider) {
  RcParameters two;
  two.J *= 2;
  two.b *= 2;
  two.K_t *= std::numbers::sqrt2;
  Bench one(make_rc_motor().device, {T, 0}, Criterion::exact_disk);
  Bench both(make_rc_motor(two).device, {T, 0}, Criterion::exact_disk);
  const auto single = one.compute();
  const auto twin = both.compute();
  for (std::size_t i = 0; i < single.size(); ++i) {
    EXPECT_NEAR(twin[i].highest.magnitude, 2 * single[i].highest.magnitude,
                1e-6 * twin[i].highest.magnitude);
    EXPECT_NEAR(twin[i].lowest.magnitude, 2 * single[i].lowest.magnitude,
                1e-6 * twin[i].lowest.magnitude);
  }
  const EnvelopeAreas a = compute_envelope_areas(single);
  const EnvelopeAreas aa = compute_envelope_areas(twin);
  EXPECT_NEAR(aa.logarithmic, a.logarithmic, 1e-6 * a.logarithmic);
  EXPECT_NEAR(aa.impedance, 2 * a.impedance, 2e-6 * a.impedance);
  EXPECT_NEAR(aa.admittance, a.admittance / 2, 1e-6 * a.admittance);
  // What the K-B plot makes of it: twice the stiffness over twice the damping.
  const double area = one.choices.front().walls.area();
  EXPECT_NEAR(both.choices.front().walls.area(), 4 * area, 1e-5 * area);
}

TEST(ImpedanceEnvelope, areas_of_a_straight_envelope_are_those_of_a_rectangle) {
  std::vector<EnvelopePoint> envelope(3);
  for (std::size_t i = 0; i < 3; ++i) {
    envelope[i].frequency_hz = std::pow(10.0, static_cast<double>(i));
    envelope[i].highest.magnitude = 50;
    envelope[i].lowest.magnitude = 0.5;
  }
  const EnvelopeAreas areas = compute_envelope_areas(envelope);
  EXPECT_DOUBLE_EQ(areas.logarithmic, 2 * 2);
  EXPECT_DOUBLE_EQ(areas.impedance, 2 * 49.5);
  EXPECT_DOUBLE_EQ(areas.admittance, 2 * 1.98);
}

TEST(ImpedanceEnvelope, is_without_bound_where_a_region_holds_walls_that_are_not_passive) {
  Bench bench(make_p3().device, {T, 0}, Criterion::exact_disk);
  // K = m w^2 and B = -b about cancel the device at 5 Hz.
  bench.choices.front().walls.outline = {{0, -2}, {0, 0}, {100, 0}, {100, -2}};
  const EnvelopePoint point = bench.compute({5.0}).front();
  EXPECT_EQ(point.lowest.magnitude, 0);
  const DisplayedLoop loop = bench.displayed.at(2 * pi * 5);
  EXPECT_LT(std::abs(loop.displayed(bench.law_at(point.lowest.wall, 5))), 1e-9 * point.bare);
}

TEST(PassiveWalls, are_told_from_others_and_refused_where_nothing_bounds_them) {
  const PassiveWalls walls{{{0, -1}, {0, 2}, {6, 2}, {3, -1}}};
  EXPECT_TRUE(walls.contains({3.9, 0}));
  EXPECT_FALSE(walls.contains({4.1, 0}));
  EXPECT_FALSE(walls.contains({1, -1.1}));
  EXPECT_FALSE(walls.contains({-0.1, 1}));
  EXPECT_DOUBLE_EQ(walls.area(), 2 * (4 + 6) / 2.0);
  // A mass without any damping: only K = B = 0 is left, and that not strictly.
  try {
    Bench(make_point_mass(0.04, 0).device, {T, 0}, Criterion::exact_disk);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_NE(std::string(error.what()).find("not even the bare device"), std::string::npos);
  }
}

}  // namespace
}  // namespace gyrator
