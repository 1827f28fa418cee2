#include "gyrator/core/calendar.hpp"

#include "gyrator/core/error.hpp"

#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

std::vector<std::string> name_ticks(const Calendar& calendar, const Calendar::Instant& instant) {
  std::vector<std::string> names;
  for (const auto& tick : instant.ticks) names.push_back(calendar.tasks()[tick.task].name);
  return names;
}

TEST(Calendar, sixty_and_two_hundred_hertz_meet_every_50_ms_for_ever) {
  Calendar calendar({{"haptic", Rational(1, 200)}, {"graphic", Rational(1, 60)}});
  int meetings = 0;
  // One hour: 720000 + 216000 ticks, 72000 of them together.
  while (calendar.peek() < 3600) {
    const auto instant = calendar.next();
    const bool is_meeting = instant.ticks.size() == 2;
    const Rational count = instant.time / Rational(1, 20);
    ASSERT_EQ(is_meeting, count.den() == 1) << instant.time.to_string();
    meetings += is_meeting ? 1 : 0;
  }
  EXPECT_EQ(meetings, 72000);
}

TEST(Calendar, ticks_are_computed_and_not_accumulated) {
  Calendar calendar({{"a", Rational(1, 3), Rational(1, 7)}, {"b", Rational(2, 7)}});
  Rational last = -1;
  for (int i = 0; i < 1000; ++i) {
    const auto instant = calendar.next();
    ASSERT_GT(instant.time, last);
    last = instant.time;
    for (const auto& tick : instant.ticks) {
      const PeriodicTask& task = calendar.tasks()[tick.task];
      ASSERT_EQ(instant.time, task.offset + Rational(tick.index) * task.period);
    }
  }
}

TEST(Calendar, gives_every_tick_of_every_task_once) {
  Calendar calendar({{"a", Rational(1, 10)}, {"b", Rational(1, 4), Rational(1, 8)}});
  std::vector<std::int64_t> ticks(2, 0);
  while (calendar.peek() <= 10) {
    for (const auto& tick : calendar.next().ticks) {
      ASSERT_EQ(tick.index, ticks[tick.task]++);
    }
  }
  EXPECT_EQ(ticks[0], count_ticks(Rational(1, 10), 0, 10));
  EXPECT_EQ(ticks[1], count_ticks(Rational(1, 4), Rational(1, 8), 10));
}

TEST(Calendar, fast_comes_before_slow_and_then_the_declaration_decides) {
  Calendar calendar({{"slow", Rational(1, 60)},
                     {"first", Rational(1, 1000)},
                     {"second", Rational(1, 1000)},
                     {"middle", Rational(1, 200)}});
  EXPECT_EQ(name_ticks(calendar, calendar.next()),
            (std::vector<std::string>{"first", "second", "middle", "slow"}));
  EXPECT_EQ(name_ticks(calendar, calendar.next()), (std::vector<std::string>{"first", "second"}));
}

TEST(Calendar, offset_of_a_whole_period_coincides_with_the_next_tick) {
  Calendar calendar(
      {{"sample", Rational(1, 1000)}, {"apply", Rational(1, 1000), Rational(1, 1000)}});
  EXPECT_EQ(name_ticks(calendar, calendar.next()), (std::vector<std::string>{"sample"}));
  const auto instant = calendar.next();
  EXPECT_EQ(name_ticks(calendar, instant), (std::vector<std::string>{"sample", "apply"}));
  EXPECT_EQ(instant.ticks[0].index, 1);
  EXPECT_EQ(instant.ticks[1].index, 0);
}

TEST(Calendar, instants_a_femtosecond_apart_are_two) {
  const Rational femtosecond(1, 1000000000000000);
  Calendar calendar({{"a", Rational(1, 1000)}, {"b", Rational(1, 1000), femtosecond}});
  EXPECT_EQ(name_ticks(calendar, calendar.next()), (std::vector<std::string>{"a"}));
  EXPECT_EQ(calendar.peek(), femtosecond);
  EXPECT_EQ(name_ticks(calendar, calendar.next()), (std::vector<std::string>{"b"}));
}

TEST(Calendar, peek_tells_the_next_instant_and_changes_nothing) {
  Calendar calendar({{"late", Rational(1, 10), Rational(1, 3)}, {"later", Rational(1, 10), 2}});
  EXPECT_EQ(calendar.peek(), Rational(1, 3));
  EXPECT_EQ(calendar.peek(), Rational(1, 3));
  EXPECT_EQ(calendar.next().time, Rational(1, 3));
  EXPECT_EQ(calendar.peek(), Rational(13, 30));
}

TEST(Calendar, copy_goes_on_by_itself) {
  Calendar original({{"a", Rational(1, 10)}});
  original.next();
  Calendar copy = original;
  copy.next();
  copy.next();
  EXPECT_EQ(original.peek(), Rational(1, 10));
  EXPECT_EQ(copy.peek(), Rational(3, 10));
}

TEST(Calendar, refuses_what_has_no_next_instant) {
  const auto place = [](std::vector<PeriodicTask> tasks) {
    try {
      Calendar calendar(std::move(tasks));
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      return error.place();
    }
    return std::string("no error");
  };
  EXPECT_EQ(place({}), "calendar");
  EXPECT_EQ(place({{"stopped", 0}}), "stopped");
  EXPECT_EQ(place({{"back", -1}}), "back");
  EXPECT_EQ(place({{"early", 1, -1}}), "early");
  EXPECT_EQ(place({{"fine", 1, 0}}), "no error");
}

TEST(Calendar, time_that_does_not_fit_is_an_error_and_not_a_wrong_time) {
  Calendar calendar({{"huge", Rational(std::int64_t{1} << 62U)}});
  EXPECT_EQ(calendar.next().time, Rational(0));
  EXPECT_THROW(calendar.next(), Error);
}

}  // namespace
}  // namespace gyrator
