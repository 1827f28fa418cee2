#include "gyrator/passivity/stiffness_limit.hpp"

#include "gyrator/controllers/virtual_wall.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

struct Case {
  std::string name;
  KnownDevice known;
  Sampling sampling;
  double virtual_damping;
};

std::vector<Case> make_cases() {
  const Rational T(1, 1000);
  const auto compliant = [](SensorLocation sensor) {
    return make_compliant(2e-5, 2e-4, {0.8, 1e-4, 1e-5}, sensor);
  };
  return {{"P3", make_p3(), {T, 0}, 0.3},
          {"P3, late", make_p3(), {T, Rational(2, 1000)}, 0.3},
          {"rc motor", make_rc_motor(), {T, 0}, 1.5e-4},
          {"rc motor, negative B", make_rc_motor(), {T, 0}, -5e-5},
          {"rc motor, late", make_rc_motor(), {T, Rational(7, 10000)}, 1e-4},
          {"rc motor, ideal drive", make_rc_motor({}, true), {T, 0}, 1.5e-4},
          {"slow amplifier", make_slow_rc_motor(300), {T, 0}, 1e-4},
          {"voltage drive", make_voltage_driven_motor(0.5), {T, 0}, 2e-4},
          {"compliant, sensor at port", compliant(SensorLocation::port), {T, 0}, 0},
          {"compliant, sensor at motor", compliant(SensorLocation::motor), {T, 0}, 5e-5},
          {"filtered sensor", behind_filter(make_p3(), {200, 2}), {T, 0}, 0.3},
          {"filtered sensor at motor, late",
           behind_filter(compliant(SensorLocation::motor), {400, 1}),
           {T, Rational(7, 10000)},
           5e-5}};
}

double find_least_margin(StiffnessLimits& limits, double stiffness, double virtual_damping) {
  const double period = limits.disk().period();
  const DiscreteStateSpace law = make_wall_law({stiffness, virtual_damping}, period);
  double least = INFINITY;
  for (const DiskPoint& point : limits.disks()) {
    least =
        std::min(least, point.damping_margin(law.response(std::polar(1.0, point.omega * period))));
  }
  return least;
}

TEST(StiffnessLimit, of_the_exact_disk_is_where_its_margin_changes_sign) {
  for (const Case& c : make_cases()) {
    StiffnessLimits limits(c.known.device, c.sampling, DifferenceEstimator{}, FreeOperator{});
    const StiffnessLimit limit = limits.find(Criterion::exact_disk, c.virtual_damping);
    ASSERT_TRUE(limit.feasible) << c.name;
    ASSERT_TRUE(std::isfinite(limit.stiffness)) << c.name;
    EXPECT_GT(find_least_margin(limits, 0.999 * limit.stiffness, c.virtual_damping), 0) << c.name;
    EXPECT_LT(find_least_margin(limits, 1.001 * limit.stiffness, c.virtual_damping), 0) << c.name;
    // Nowhere below, either: every smaller stiffness is passive, too.
    for (const double share : {1e-4, 0.01, 0.1, 0.3, 0.6, 0.9}) {
      EXPECT_GT(find_least_margin(limits, share * limit.stiffness, c.virtual_damping), 0)
          << c.name << ' ' << share;
    }
  }
}

TEST(StiffnessLimit, binds_at_the_frequency_that_it_names) {
  for (const Case& c : make_cases()) {
    StiffnessLimits limits(c.known.device, c.sampling, DifferenceEstimator{}, FreeOperator{});
    const StiffnessLimit limit = limits.find(Criterion::exact_disk, c.virtual_damping);
    const double omega = 2 * pi * limit.worst_frequency_hz;
    const double period = limits.disk().period();
    const DiskPoint point = limits.disk().at(omega);
    const auto margin = [&](double share) {
      const DiscreteStateSpace law =
          make_wall_law({share * limit.stiffness, c.virtual_damping}, period);
      return point.damping_margin(law.response(std::polar(1.0, omega * period)));
    };
    // Nothing is left there, against what a hundredth of the stiffness makes.
    EXPECT_LT(std::abs(margin(1)), 1e-6 * std::abs(margin(0.99))) << c.name;
  }
}

TEST(StiffnessLimit, of_the_textbook_is_the_disks_for_a_constant_damping) {
  for (const auto& [delay, B] : {std::pair(Rational(0), 0.0),
                                 {Rational(0), 0.4},
                                 {Rational(0), -0.3},
                                 {Rational(1, 1000), 0.2},
                                 {Rational(2, 1000), -0.1}}) {
    StiffnessLimits limits(make_p3().device, {Rational(1, 1000), delay}, DifferenceEstimator{},
                           FreeOperator{});
    const double textbook = limits.find(Criterion::frequency_dependent, B).stiffness;
    // The disk's series is good to 1e-11.
    EXPECT_NEAR(limits.find(Criterion::exact_disk, B).stiffness, textbook, 1e-9 * textbook) << B;
  }
}

TEST(StiffnessLimit, is_not_feasible_where_the_damper_alone_breaks_the_criterion) {
  StiffnessLimits limits(make_p3().device, {}, DifferenceEstimator{}, FreeOperator{});
  for (const Criterion criterion :
       {Criterion::spring_damper, Criterion::frequency_dependent, Criterion::exact_disk}) {
    EXPECT_TRUE(limits.find(criterion, 0.8 * 0.999).feasible) << name_of(criterion);
    EXPECT_FALSE(limits.find(criterion, 0.8 * 1.001).feasible) << name_of(criterion);
    EXPECT_FALSE(limits.find(criterion, -0.8 * 1.001).feasible) << name_of(criterion);
  }
}

TEST(StiffnessLimit, with_any_passive_operator_is_at_least_that_for_all_of_them) {
  Random random(6);
  int bounded = 0;
  for (const Case& c : make_cases()) {
    StiffnessLimits limits(c.known.device, c.sampling, DifferenceEstimator{}, FreeOperator{});
    const double for_all = limits.find(Criterion::exact_disk, c.virtual_damping).stiffness;
    const double inertia = c.known.device.mechanics.inertia;
    for (int i = 0; i < 25; ++i) {
      MassSpringDamper held_by;
      if (i > 0) {
        held_by = {random.log_uniform(1e-2, 1e2) * inertia,
                   random.log_uniform(1e-3, 1) * inertia * 1e3,
                   random.log_uniform(1e-4, 1) * inertia * 1e6,
                   {}};
        if (random.chance(0.5)) held_by.damping = 0;
      }
      StiffnessLimits coupled(c.known.device, c.sampling, DifferenceEstimator{}, held_by);
      const StiffnessLimit limit = coupled.find(Criterion::coupled, c.virtual_damping);
      ASSERT_TRUE(limit.feasible) << c.name << ' ' << i;
      // Its crossing is bracketed to 2^-44 and eigenvalues close to one move with the root of
      // rounding.
      EXPECT_GE(limit.stiffness, for_all * (1 - 1e-6)) << c.name << ' ' << i;
      bounded += std::isfinite(limit.stiffness);
    }
  }
  EXPECT_GT(bounded, 200);
}

TEST(StiffnessLimit, coupled_is_where_the_exact_loop_turns_unstable) {
  for (const Case& c : make_cases()) {
    const MassSpringDamper hand{c.known.device.mechanics.inertia, 0, 0, {}};
    StiffnessLimits limits(c.known.device, c.sampling, DifferenceEstimator{}, hand);
    const StiffnessLimit limit = limits.find(Criterion::coupled, c.virtual_damping);
    ASSERT_TRUE(limit.feasible && std::isfinite(limit.stiffness)) << c.name;
    const double period = c.sampling.period.to_double();
    const SampledPlant plant =
        sample_plant(build_plant(build_device_network(c.known.device, hand)), c.sampling);
    const auto radius = [&](double share) {
      return compute_spectral_radius(build_loop_matrix(
          plant, make_wall_law({share * limit.stiffness, c.virtual_damping}, period)));
    };
    EXPECT_LT(radius(0.999), 1) << c.name;
    EXPECT_GT(radius(1.001), 1) << c.name;
  }
}

TEST(StiffnessLimit, lists_every_criterion_under_its_own_name) {
  for (const CriterionName& entry : criterion_names())
    EXPECT_EQ(name_of(entry.criterion), entry.name);
  EXPECT_EQ(name_of(Criterion::spring_damper), "spring_damper");
  EXPECT_EQ(name_of(Criterion::frequency_dependent), "frequency_dependent");
  EXPECT_EQ(name_of(Criterion::exact_disk), "exact_disk");
  EXPECT_EQ(name_of(Criterion::coupled), "coupled");
}

// Z = m s + b, A = 1, S = F, M = 0, H = K: as w -> 0 the base term of (disk-3) lags by all delays,
// and each alias adds what its filtered disk, turned by arg F, has more of radius than of centre
// towards -1/H:
//   D -> b - K (T/2 + t_d + D_f) - K^2/(2 b) sum_{n != 0} (|F_n| - Re F_n)/(n w_s)^2,
// D_f = 1/w_c or sqrt(2)/w_c, t_d whole periods. The mass does not enter.
double find_filtered_limit(const SensorFilter& filter, double b, double period, double delay) {
  const double lag = (filter.order == 1 ? 1 : std::numbers::sqrt2) / (2 * pi * filter.cutoff_hz);
  double aliases = 0;
  for (int n = 1; n < 20000; ++n) {
    const double omega = 2 * pi * n / period;
    const Complex F = filter_response(filter, Complex(0, omega));
    aliases += 2 * (std::abs(F) - F.real()) / (omega * omega);
  }
  const double slope = period / 2 + delay + lag;
  return 2 * b / (slope + std::sqrt(slope * slope + 2 * aliases));
}

TEST(StiffnessLimit, of_a_spring_behind_a_filter_counts_the_filters_lag_beside_hold_and_delay) {
  const double b = 0.8;
  const double T = 1e-3;
  for (const SensorFilter& filter : {SensorFilter{50, 1}, SensorFilter{400, 1}, SensorFilter{20, 2},
                                     SensorFilter{200, 2}, SensorFilter{5e3, 1}}) {
    for (const int late : {0, 1, 3}) {
      const Device device = behind_filter(make_point_mass(0.04, b), filter).device;
      StiffnessLimits limits(device, {Rational(1, 1000), Rational(late, 1000)},
                             DifferenceEstimator{}, FreeOperator{});
      const StiffnessLimit limit = limits.find(Criterion::exact_disk, 0);
      // The sum's tail beyond 2e4 aliases, and the lowest frequency in place of zero (1e-4 of the
      // slowest pole, squared).
      const double wanted = find_filtered_limit(filter, b, T, late * T);
      EXPECT_NEAR(limit.stiffness, wanted, 1e-6 * wanted)
          << filter.cutoff_hz << " Hz, late " << late;
      // The aliases take 3.9 % at most, over all cut-offs: b > K (T/2 + t_d + lag) nearly says it
      // all.
      const double plain = b / (T / 2 + late * T + find_lag(filter));
      EXPECT_LT(limit.stiffness, plain) << filter.cutoff_hz;
      EXPECT_GT(limit.stiffness, 0.95 * plain) << filter.cutoff_hz;
      EXPECT_LT(limit.worst_frequency_hz, 1) << filter.cutoff_hz;
    }
  }
}

}  // namespace
}  // namespace gyrator
