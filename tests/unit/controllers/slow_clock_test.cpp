#include "gyrator/controllers/slow_clock.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

const Rational millisecond(1, 1000);

TEST(SlowClock, a_sixtieth_of_a_second_falls_on_the_right_millisecond_for_an_hour) {
  SlowClock clock({.period = Rational(1, 60)}, millisecond);
  std::int64_t slow = 0;
  for (std::int64_t fast = 0; fast < 3'600'000; ++fast) {
    // j/60 s is 50 j/3 ms: due at the first millisecond at or after it, in whole numbers.
    const bool expected = fast == (50 * slow + 2) / 3;
    ASSERT_EQ(clock.advance(), expected) << fast;
    ASSERT_EQ(clock.fast_tick(), fast);
    if (expected) ++slow;
  }
  EXPECT_EQ(slow, 60 * 3600);
}

TEST(SlowClock, a_result_is_used_at_the_first_fast_tick_after_its_delay_and_never_at_once) {
  for (const Rational& delay :
       {Rational(0), Rational(1, 10'000), Rational(1, 400), Rational(1, 20)}) {
    SlowClock clock({.period = Rational(1, 60), .delay = delay}, millisecond);
    std::int64_t slow = 0;
    for (std::int64_t fast = 0; fast < 10'000; ++fast) {
      if (!clock.advance()) continue;
      const Rational instant = Rational(slow++, 60) + delay;
      const std::int64_t expected = std::max(ceil_divide(instant, millisecond), fast + 1);
      ASSERT_EQ(clock.find_arrival(), expected) << fast;
    }
  }
}

TEST(SlowClock, an_environment_as_fast_as_the_loop_is_part_of_it) {
  SlowLink<int> at_once({}, millisecond);
  SlowLink<int> late({.delay = Rational(5, 2000)}, millisecond);  // 2.5 ticks
  for (int k = 0; k < 20; ++k) {
    EXPECT_EQ(at_once.exchange([&] { return k; }), k);
    EXPECT_EQ(late.exchange([&] { return k; }), std::max(0, k - 3)) << k;
    EXPECT_EQ(late.arrived(), k >= 3);
  }
}

TEST(SlowClock, many_results_may_be_under_way) {
  // 33 ms of delay behind updates of 2 ms: what is used at tick k was computed 33 ticks before, or
  // at the even tick before that.
  SlowLink<int> link({.period = Rational(1, 500), .delay = Rational(33, 1000)}, millisecond);
  for (int k = 0; k < 500; ++k) {
    const int used = link.exchange([&] { return k; });
    EXPECT_EQ(used, k < 33 ? 0 : (k - 33) / 2 * 2) << k;
  }
}

TEST(SlowClock, loses_as_many_updates_as_it_is_told_to_and_keeps_the_last_that_came) {
  constexpr int updates = 100'000;
  constexpr double loss = 0.3;
  SlowLink<int> link({.period = Rational(1, 500), .loss = loss, .seed = 7}, millisecond);
  int computed = 0, arrived = 0, last = 0;
  for (int k = 0; k < 2 * updates; ++k) {
    const int used = link.exchange([&] { return ++computed; });
    if (link.arrived()) {
      ++arrived;
      last = computed;  // of the tick before
      if (arrived == 1) {
        EXPECT_EQ(used, 1) << "the first is never lost";
      }
    }
    ASSERT_EQ(used, last);
  }
  // Binomial: five standard deviations, once in two million seeds.
  const double deviation = std::sqrt(updates * loss * (1 - loss));
  EXPECT_NEAR(arrived, updates * (1 - loss), 5 * deviation);
}

TEST(SlowClock, never_loses_the_first_result) {
  for (std::uint64_t seed = 1; seed < 30; ++seed) {  // 0.1^29: one would be lost
    SlowLink<int> link({.period = Rational(1, 500), .loss = 0.9, .seed = seed}, millisecond);
    link.exchange([] { return 5; });
    EXPECT_EQ(link.exchange([] { return 6; }), 5) << seed;
  }
}

TEST(SlowClock, loses_the_same_updates_with_the_same_seed_only) {
  const auto run = [](std::uint64_t seed) {
    SlowLink<int> link({.period = Rational(1, 500), .loss = 0.5, .seed = seed}, millisecond);
    std::vector<int> used;
    for (int k = 0; k < 400; ++k) used.push_back(link.exchange([&] { return k; }));
    return used;
  };
  EXPECT_EQ(run(3), run(3));
  EXPECT_NE(run(3), run(4));
}

TEST(SlowClock, refuses_rates_that_do_not_nest_and_impossible_transport) {
  const auto message = [](const SlowUpdate& update) -> std::string {
    try {
      SlowClock(update, millisecond);
      return "";
    } catch (const Error& error) {
      return error.place() + ": " + error.message();
    }
  };
  EXPECT_NE(message({.period = Rational(1, 2000)}).find("rates that do not nest"),
            std::string::npos);
  EXPECT_EQ(message({.period = Rational(1, 2000)}).find("controller/update/period"), 0U);
  EXPECT_EQ(message({.delay = Rational(-1, 1000)}).find("controller/update/delay"), 0U);
  EXPECT_EQ(message({.loss = 1}).find("controller/update/loss"), 0U);
  EXPECT_EQ(message({.loss = -0.1}).find("controller/update/loss"), 0U);
  EXPECT_EQ(message({.period = millisecond, .loss = 0.999}), "");
}

}  // namespace
}  // namespace gyrator
