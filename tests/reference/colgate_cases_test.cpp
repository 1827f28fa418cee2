// Cases 1 to 6 of the reference: passivity of sampled walls on plants with constant damping.

#include "gyrator/passivity/verdict.hpp"
#include "gyrator/passivity/virtual_damping.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "reference_plants.hpp"

namespace gyrator {
namespace {

using namespace reference;
using std::numbers::pi;

constexpr std::array every_criterion{Criterion::spring_damper, Criterion::frequency_dependent,
                                     Criterion::exact_disk};

// For constant damping and whole delays the three agree; the disk's series is good to 1e-11.
constexpr double agreement = 1e-9;

double find_limit(const Device& device, const Sampling& sampling, Criterion criterion, double B,
                  const VelocityEstimator& estimator = DifferenceEstimator{}) {
  return StiffnessLimits(device, sampling, estimator, FreeOperator{}).find(criterion, B).stiffness;
}

TEST(ColgateCases, case_1_a_spring_is_passive_up_to_twice_the_damping_over_the_period) {
  // Published: P3, 1 / 2 / 5 ms: K <= 1600 / 800 / 320 N/m.
  struct Row {
    int milliseconds;
    double stiffness;
  };
  for (const Row& row : {Row{1, 1600}, {2, 800}, {5, 320}}) {
    for (const Criterion criterion : every_criterion) {
      EXPECT_NEAR(find_limit(make_p3(), at(row.milliseconds), criterion, 0), row.stiffness,
                  agreement * row.stiffness)
          << name_of(criterion) << ", " << row.milliseconds << " ms";
    }
  }
}

TEST(ColgateCases, case_2_virtual_damping_halves_the_stiffness_and_binds_at_nyquist) {
  // Published: P3, 1 ms, B 0.4 N.s/m: K <= 800 N/m.
  for (const Criterion criterion : every_criterion) {
    StiffnessLimits limits(make_p3(), at(1), DifferenceEstimator{}, FreeOperator{});
    const StiffnessLimit limit = limits.find(criterion, 0.4);
    EXPECT_NEAR(limit.stiffness, 800, 800 * agreement) << name_of(criterion);
    EXPECT_NEAR(limit.worst_frequency_hz, 500, 1e-3) << name_of(criterion);
  }
}

TEST(ColgateCases, case_3_an_eighth_of_the_damping_carries_an_eighth_of_the_stiffness) {
  // Published: b 0.1 N.s/m, 1 ms: K <= 200 N/m, whatever the mass.
  for (const double mass : {0.04, 0.5}) {
    for (const Criterion criterion : every_criterion) {
      EXPECT_NEAR(find_limit(make_plant(mass, 0.1), at(1), criterion, 0), 200, 200 * agreement)
          << name_of(criterion);
    }
  }
}

TEST(ColgateCases, case_4_a_delay_counts_in_full_and_not_by_half) {
  // Published: P3, 1 ms, 100 / 50 ms late: K <= b/(T/2 + T_d) = 7.960199 / 15.8416 N/m.
  // The closed form is the limit at zero frequency; the judging grid starts at 1e-4 of the plant's
  // pole, 2e-3 rad/s, where (w (T + T_d))^2/6 is 7e-9.
  for (const auto& [delay, figure, digit] :
       {std::tuple(100, 7.960199, 1e-6), std::tuple(50, 15.8416, 1e-4)}) {
    const double closed_form = 0.8 / (0.5e-3 + delay * 1e-3);
    EXPECT_NEAR(closed_form, figure, digit);
    for (const Criterion criterion : {Criterion::frequency_dependent, Criterion::exact_disk}) {
      const double limit = find_limit(make_p3(), at(1, Rational(delay, 1000)), criterion, 0);
      EXPECT_NEAR(limit, closed_form, 1e-8 * closed_form) << name_of(criterion);
      EXPECT_LT(limit, 0.51 * 2 * 0.8 / (1e-3 + delay * 1e-3)) << "2b/(T + T_d) is wrong";
    }
  }
}

TEST(ColgateCases, case_4_a_spring_late_by_a_delay_is_judged_from_both_sides) {
  for (const int delay : {50, 100}) {
    const double K = 0.8 / (0.5e-3 + delay * 1e-3);
    const Sampling sampling = at(1, Rational(delay, 1000));
    EXPECT_TRUE(
        judge_passivity({make_p3(), VirtualWall{0.999 * K, 0}, sampling, 0}, false).passive);
    EXPECT_FALSE(
        judge_passivity({make_p3(), VirtualWall{1.001 * K, 0}, sampling, 0}, false).passive);
  }
}

struct DelayAndDamping {
  int samples;
  double needed, worst;  // N.s/m, share of Nyquist
};
constexpr std::array case_5{DelayAndDamping{1, 1.6250, 0.420}, DelayAndDamping{2, 1.93971, 0.2215}};

TEST(ColgateCases,
     case_5_the_damping_needed_with_a_delay_and_virtual_damping_is_found_by_bisection) {
  // Derived: K 1000 N/m, B 1 N.s/m, 1 ms.
  for (const DelayAndDamping& row : case_5) {
    const Sampling sampling = at(1, Rational(row.samples, 1000));
    const auto is_passive = [&](double b) {
      return judge_passivity({make_plant(0.04, b), VirtualWall{1000, 1}, sampling, 0}, false)
          .passive;
    };
    double low = 1;
    double high = 3;
    ASSERT_FALSE(is_passive(low));
    ASSERT_TRUE(is_passive(high));
    while (high - low > 1e-6) {
      const double middle = (low + high) / 2;
      (is_passive(middle) ? high : low) = middle;
    }
    // Half of the figure's last digit.
    EXPECT_NEAR(high, row.needed, row.samples == 1 ? 5e-5 : 5e-6);
  }
}

TEST(ColgateCases, case_5_both_frequency_domain_criteria_miss_that_much_damping_at_that_frequency) {
  for (const DelayAndDamping& row : case_5) {
    const Verdict verdict = judge_passivity(
        {make_p3(), VirtualWall{1000, 1}, at(1, Rational(row.samples, 1000)), 0}, false);
    for (const CriterionResult& criterion : verdict.criteria) {
      if (criterion.name != "frequency_dependent" && criterion.name != "exact_disk") continue;
      EXPECT_TRUE(criterion.applies) << criterion.name;
      EXPECT_NEAR(0.8 - criterion.margin, row.needed, row.samples == 1 ? 5e-5 : 5e-6)
          << criterion.name;
      EXPECT_NEAR(*criterion.worst_frequency_hz / 500, row.worst, row.samples == 1 ? 5e-4 : 5e-5)
          << criterion.name;
    }
  }
}

struct FilteredDifference {
  double K, B, tau, needed;
};

TEST(ColgateCases, case_6_a_filtered_difference_needs_less_damping_by_its_filter) {
  // Setup published (Brown 1995), form derived: b > KT/2 + B T/(T + 2 tau) for B >= 0,
  // KT/2 + |B| for B < 0, T 1 ms.
  for (const FilteredDifference& row : {FilteredDifference{1000, 1, 2e-3, 0.700000},
                                        {1000, -0.5, 2e-3, 1.000000},
                                        {1000, 5, 5.3e-3, 0.931034}}) {
    const double T = 1e-3;
    const double form = row.K * T / 2 + (row.B >= 0 ? row.B * T / (T + 2 * row.tau) : -row.B);
    EXPECT_NEAR(form, row.needed, 5e-7);
    const VelocityEstimator filter = FilteredDifferenceEstimator{1 / (2 * pi * row.tau)};
    // With exactly that damping the stiffness is the limit. (For B < 0 at the lowest frequency of
    // the judging grid, where (w tau)^2 is below 1e-4 (b/m)^2 tau^2.)
    for (const Criterion criterion : {Criterion::frequency_dependent, Criterion::exact_disk}) {
      EXPECT_NEAR(find_limit(make_plant(0.04, form), at(1), criterion, row.B, filter), row.K,
                  1e-8 * row.K)
          << name_of(criterion) << ' ' << row.B;
    }
    const VirtualWall wall{row.K, row.B, filter};
    EXPECT_TRUE(
        judge_passivity({make_plant(0.04, form * (1 + 1e-6)), wall, at(1), 0}, false).passive);
    EXPECT_FALSE(
        judge_passivity({make_plant(0.04, form * (1 - 1e-6)), wall, at(1), 0}, false).passive);
  }
}

}  // namespace
}  // namespace gyrator
