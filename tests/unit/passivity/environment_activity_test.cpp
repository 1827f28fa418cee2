#include "gyrator/passivity/environment_activity.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

const Rational T(1, 1000);
const std::vector<Rational> delays{0,
                                   Rational(1, 10000),
                                   Rational(5, 10000),
                                   Rational(1, 1000),
                                   Rational(27, 10000),
                                   Rational(3, 1000)};

EnvironmentProfile make_spring(double stiffness) {
  return {{-1, 1}, {-stiffness, stiffness}};
}

// A soft start, a steep rise of 400, a fall of 150 behind it.
EnvironmentProfile make_button() {
  return {{0, 0.010, 0.020, 0.025, 0.040}, {0, 0.5, 4.5, 3.75, 5}};
}

// A motion of constant velocity in each late part (the delay's rest) and each other part of every
// period, and what a held profile makes of it.
class Motion {
 public:
  Motion(double start, const Sampling& sampling)
      : position_{start},
        period_(sampling.period.to_double()),
        whole_(floor_divide(sampling.delay, sampling.period)),
        late_((sampling.delay - Rational(whole_) * sampling.period).to_double()) {}

  void move(double in_late_part, double in_other_part) {
    if (late_ == 0) in_other_part += std::exchange(in_late_part, 0);  // there is none
    if (late_ > 0) square_ += in_late_part * in_late_part / late_;
    square_ += in_other_part * in_other_part / (period_ - late_);
    position_.push_back(position_.back() + in_late_part);
    position_.push_back(position_.back() + in_other_part);
  }

  void return_to_start(long periods) {
    const double step = (position_.front() - position_.back()) / static_cast<double>(periods);
    for (long k = 0; k < periods; ++k) move(step * late_ / period_, step * (1 - late_ / period_));
    for (long k = 0; k <= whole_ + 1; ++k) move(0, 0);  // until the last command has ended
  }

  // Energy that the environment gave: the opposing f(x_k) over the motion while it is held.
  double energy(const EnvironmentProfile& profile) const {
    double given = 0;
    const auto periods = static_cast<long>(position_.size() / 2);
    const auto at = [&](long k) { return position_[static_cast<std::size_t>(2 * k)]; };
    // Position when the command of sample k takes effect.
    const auto effective = [&](long k) {
      const long index = 2 * (k + whole_) + (late_ > 0 ? 1 : 0);
      return position_[static_cast<std::size_t>(
          std::min<long>(index, static_cast<long>(position_.size()) - 1))];
    };
    for (long k = 0; k < periods; ++k)
      given -= profile.at(at(k)) * (effective(k + 1) - effective(k));
    // Before the first command the effort of the start was held.
    given -= profile.at(position_.front()) * (effective(0) - position_.front());
    return given;
  }

  double square() const { return square_; }

 private:
  std::vector<double> position_;
  double period_;
  long whole_;
  double late_;
  double square_ = 0;
};

TEST(EnvironmentActivity, of_a_spring_is_half_a_period_and_the_delay_of_it) {
  EXPECT_DOUBLE_EQ(compute_environment_activity(make_spring(300), {T, 0}).alpha, 0.15);
  EXPECT_DOUBLE_EQ(compute_environment_activity(make_spring(300), {T, Rational(2, 1000)}).alpha,
                   0.15 + 0.6);
  // By hand for half a period: T K/2 (1 + sqrt(1 + 1/4)).
  EXPECT_NEAR(compute_environment_activity(make_spring(300), {T, Rational(5, 10000)}).alpha,
              0.15 * (1 + std::sqrt(1.25)), 1e-15);
  // A falling slope needs nothing without delay.
  EXPECT_EQ(compute_environment_activity(make_spring(-300), {T, 0}).alpha, 0);
  EXPECT_DOUBLE_EQ(compute_environment_activity(make_spring(-300), {T, Rational(1, 1000)}).alpha,
                   0.3);
  const EnvironmentActivity button = compute_environment_activity(make_button(), {T, 0});
  EXPECT_NEAR(button.rising.slope, 400, 1e-10);
  EXPECT_NEAR(button.falling.slope, 150, 1e-10);
  EXPECT_EQ(button.rising.from, 0.010);
  EXPECT_EQ(button.falling.to, 0.025);
}

TEST(EnvironmentActivity, of_a_spring_is_the_damping_that_the_exact_disk_asks_for) {
  constexpr double b = 0.8;
  for (const Rational& delay : delays) {
    const Sampling sampling{T, delay};
    StiffnessLimits limits(make_point_mass(0.04, b).device, sampling, DifferenceEstimator{},
                           FreeOperator{});
    const double K = limits.find(Criterion::exact_disk, 0).stiffness;
    const double alpha = compute_environment_activity(make_spring(K), sampling).alpha;
    // The disk cuts the tail of a fractional delay after 200 aliases and adds its bound, 1/200 of
    // the aliases' sum pi^2/6: 0.3 % of a term that is at most a tenth of the whole.
    EXPECT_NEAR(alpha, b, 1e-3 * b) << delay.to_double();
    EXPECT_LT(alpha, b * (1 + 1e-6)) << delay.to_double();
  }
}

TEST(EnvironmentActivity, is_attained_by_a_motion_in_the_steepest_part) {
  for (const Rational& delay : delays) {
    const Sampling sampling{T, delay};
    const EnvironmentProfile profile = make_button();
    const EnvironmentActivity activity = compute_environment_activity(profile, sampling);
    const double share = find_worst_share(activity, sampling);
    constexpr int periods = 2000;
    Motion motion(0.012, sampling);
    // Within the steep part: 2000/pi times 1e-5 is 6.4 mm, and back.
    for (int k = 0; k < periods; ++k) {
      const double step = 1e-5 * std::sin(2 * pi * (k + 0.5) / periods);
      motion.move(step * share, step * (1 - share));
    }
    motion.return_to_start(1);
    const double attained = motion.energy(profile) / motion.square();
    EXPECT_LT(attained, activity.alpha * (1 + 1e-9)) << delay.to_double();
    // What the slow turn costs is the square of the motion's angle during the loop's lag.
    EXPECT_GT(attained, activity.alpha * (1 - 1e-3)) << delay.to_double();
    // A constant velocity comes close, but attains it with whole delays only.
    if (delay.to_double() == 5e-4) {
      EXPECT_LT(T.to_double() * 400, 0.95 * activity.alpha);
    }
  }
}

TEST(EnvironmentActivity, is_exceeded_by_no_motion) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(0, 1);
  double closest = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const Sampling sampling{T, delays[static_cast<std::size_t>(trial) % delays.size()]};
    EnvironmentProfile profile;
    double x = 0;
    for (int i = 0; i < 6; ++i) {
      profile.position.push_back(x);
      profile.effort.push_back(normal(random));
      x += 1e-3 + 5e-3 * share(random);
    }
    Motion motion(x * share(random), sampling);
    const double size = std::pow(10.0, -4 + 2.5 * share(random));
    const double late = share(random);
    double drift = normal(random);
    for (int k = 0; k < 40; ++k) {
      drift = 0.8 * drift + normal(random);
      motion.move(size * drift * late, size * drift * (1 - late));
    }
    motion.return_to_start(5);
    const double alpha = compute_environment_activity(profile, sampling).alpha;
    const double given = motion.energy(profile) / motion.square();
    EXPECT_LT(given, alpha * (1 + 1e-9)) << trial;
    closest = std::max(closest, given / alpha);
  }
  EXPECT_GT(closest, 0.5);  // the motions are no harmless ones
}

TEST(EnvironmentActivity, with_a_falling_slope_the_bound_is_on_the_safe_side_and_needs_the_delay) {
  // Back and forth from sample to sample, one period late: the linear worst case is K T/2.
  const Sampling late{T, Rational(1, 1000)};
  Motion motion(0, late);
  for (int k = 0; k < 200; ++k) motion.move(0, k % 2 == 0 ? 1e-4 : -1e-4);
  motion.return_to_start(1);
  const double given = motion.energy(make_spring(-300)) / motion.square();
  EXPECT_NEAR(given, 0.15, 0.15 / 50);  // 200 turns; start and end lack their companions
  EXPECT_LT(given, compute_environment_activity(make_spring(-300), late).alpha);
}

TEST(EnvironmentVerdict, changes_where_the_damping_is_used_up) {
  constexpr double b = 0.8;
  const Device device = make_point_mass(0.04, b).device;
  const double K = 2 * b / T.to_double();
  for (const double gamma : {0.3, 5.0}) {
    const double softer = K * gamma / (b + gamma);  // the two dampers in series [8.30]
    for (const double factor : {0.999, 1.001}) {
      const bool expected = factor < 1;
      const auto direct = judge_environment(make_spring(factor * K), device, {T, 0}, {});
      EXPECT_EQ(direct.holds(), expected);
      EXPECT_NEAR(direct.dissipation, b, 1e-9);
      const auto coupled = judge_environment(make_spring(factor * softer), device, {T, 0}, gamma);
      EXPECT_EQ(coupled.holds(), expected);
      EXPECT_LT(coupled.allowed, direct.allowed);
    }
  }
  EXPECT_THROW(judge_environment(make_spring(1), device, {T, 0}, 0.0), Error);
}

TEST(EnvironmentVerdict, says_nothing_where_the_command_takes_another_path) {
  const auto verdict = judge_environment(make_spring(1e-4), make_rc_motor().device, {T, 0}, {});
  EXPECT_TRUE(verdict.inequality);
  EXPECT_FALSE(verdict.holds());
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_NE(verdict.reasons.front().find("A is not 1"), std::string::npos);
  EXPECT_TRUE(
      judge_environment(make_spring(1e-4), make_rc_motor({}, true).device, {T, 0}, {}).holds());
}

TEST(EnvironmentProfile, is_refused_unless_its_positions_increase) {
  EXPECT_THROW((EnvironmentProfile{{0}, {0}}.check()), Error);
  EXPECT_THROW((EnvironmentProfile{{0, 1}, {0}}.check()), Error);
  EXPECT_THROW((EnvironmentProfile{{0, 1, 1}, {0, 1, 2}}.check()), Error);
  const EnvironmentProfile button = make_button();
  EXPECT_EQ(button.at(-1), 0);
  EXPECT_EQ(button.at(1), 5);
  EXPECT_DOUBLE_EQ(button.at(0.015), 2.5);
}

}  // namespace
}  // namespace gyrator
