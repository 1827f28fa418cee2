#include "gyrator/regression/trace_tube.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Column = std::vector<double>;

TraceExpectation make_tube(double absolute, double time_s, double relative = 0) {
  return {{{"position", absolute, relative}}, time_s};
}

TraceTable make_table(Column t, Column y) {
  return {std::move(t), {std::move(y)}};
}

// A trapezium: 0, up to 1 over [1, 2], 1 until 3, down to 0 at 4, 0 until 5.
TraceTable make_reference() {
  return make_table({0, 1, 2, 3, 4, 5}, {0, 0, 1, 1, 0, 0});
}

TraceTable raised(TraceTable table, double by) {
  for (double& value : table.columns[0]) value += by;
  return table;
}

TraceTable delayed(TraceTable table, double by) {
  for (double& t : table.time_s) t += by;
  table.time_s.insert(table.time_s.begin(), 0);
  table.columns[0].insert(table.columns[0].begin(), table.columns[0].front());
  table.time_s.back() = 5;
  return table;
}

constexpr double just = 0x1p-30;

TEST(TraceTube, TheReferenceItselfIsInsideItsTube) {
  EXPECT_FALSE(find_tube_exit(make_reference(), make_reference(), make_tube(just, 0)));
}

TEST(TraceTube, HeightHoldsUpToItsLimitOnBothSides) {
  const TraceTable reference = make_reference();
  for (const double side : {1.0, -1.0}) {
    EXPECT_FALSE(
        find_tube_exit(raised(reference, side * 0.125), reference, make_tube(0.125, 0.25)));
    const auto exit =
        find_tube_exit(raised(reference, side * (0.125 + just)), reference, make_tube(0.125, 0.25));
    ASSERT_TRUE(exit);
    EXPECT_EQ(exit->time_s, 0);
    EXPECT_NEAR(exit->outside, just, 1e-15);
    EXPECT_EQ(exit->limit, side * 0.125);
  }
}

TEST(TraceTube, AShiftInTimeHoldsUpToItsLimit) {
  const TraceTable reference = make_reference();
  EXPECT_FALSE(find_tube_exit(delayed(reference, 0.25), reference, make_tube(1e-12, 0.25)));
  const auto exit =
      find_tube_exit(delayed(reference, 0.25 + just), reference, make_tube(1e-12, 0.25));
  ASSERT_TRUE(exit);
  // First where the reference, at the latest, is rising and the delayed one not yet.
  EXPECT_NEAR(exit->time_s, 1.25, 1e-6);
  EXPECT_NEAR(exit->outside, just, 1e-11);
  // Pointwise, without tolerance in time, the same shift is a quarter away.
  const auto pointwise = find_tube_exit(delayed(reference, 0.25), reference, make_tube(0.125, 0));
  ASSERT_TRUE(pointwise);
  EXPECT_NEAR(pointwise->outside, 0.125, 1e-12);
}

TEST(TraceTube, BetweenTheRowsTheTraceIsALine) {
  // One long line across the plateau's edge: its own two rows are inside.
  const TraceTable reference = make_table({0, 1, 2, 3, 4}, {0, 0, -1, 0, 0});
  const TraceTable trace = make_table({0, 4}, {0, 0});
  const auto exit = find_tube_exit(trace, reference, make_tube(0.5, 0));
  ASSERT_TRUE(exit);
  EXPECT_NEAR(exit->time_s, 2, 0.6);
  EXPECT_NEAR(exit->outside, 0.5, 1e-12);
  EXPECT_FALSE(find_tube_exit(trace, reference, make_tube(1, 0)));
}

TEST(TraceTube, ANotchOfTheEdgeBetweenTwoRisesIsSeen) {
  // r falls to 0 at 1 and rises again; with dt = 0.25 the upper edge is lowest, 0.25, where the
  // window's two ends are level, and there is no row.
  const TraceTable reference = make_table({0, 1, 2.5}, {1, 0, 1.5});
  const TraceTable level = make_table({0, 2.5}, {0.25, 0.25});
  const auto exit = find_tube_exit(make_table({0.5, 1.5}, {0.25 + just, 0.25 + just}),
                                   make_table({0.5, 1, 1.5}, {0.5, 0, 0.5}), make_tube(0, 0.25));
  ASSERT_TRUE(exit);
  EXPECT_EQ(exit->time_s, 1);
  EXPECT_FALSE(find_tube_exit(make_table({0.5, 1.5}, {0.25, 0.25}),
                              make_table({0.5, 1, 1.5}, {0.5, 0, 0.5}), make_tube(0, 0.25)));
  EXPECT_TRUE(find_tube_exit(level, reference, make_tube(0, 0)));
}

TEST(TraceTube, AJumpIsNoFault) {
  const TraceTable reference = make_table({0, 1, 1, 2, 2, 3}, {0, 0, 1, 1, 0, 0});
  EXPECT_FALSE(find_tube_exit(reference, reference, make_tube(1e-9, 0)));
  EXPECT_FALSE(find_tube_exit(reference, reference, make_tube(1e-9, 0.1)));
  const TraceTable late = make_table({0, 1.125, 1.125, 2, 2, 3}, {0, 0, 1, 1, 0, 0});
  EXPECT_FALSE(find_tube_exit(late, reference, make_tube(1e-9, 0.125)));
  const auto exit = find_tube_exit(late, reference, make_tube(1e-9, 0.1));
  ASSERT_TRUE(exit);
  EXPECT_NEAR(exit->time_s, 1.1, 1e-12);
  EXPECT_NEAR(exit->outside, 1, 1e-6);
}

TEST(TraceTube, ATraceThatEndsElsewhereIsOutside) {
  const TraceTable reference = make_reference();
  const TraceTable early = make_table({0, 1, 2, 3, 4, 4.5}, {0, 0, 1, 1, 0, 0});
  EXPECT_FALSE(find_tube_exit(early, reference, make_tube(0.1, 0.5)));
  const auto exit = find_tube_exit(early, reference, make_tube(0.1, 0.4));
  ASSERT_TRUE(exit);
  EXPECT_TRUE(exit->is_end);
}

TEST(TraceTube, JumpsAtTheFirstAndTheLastInstantAreHeld) {
  const TraceTable reference = make_reference();
  const TraceTable first = make_table({0, 0, 1, 2, 3, 4, 5}, {9, 0, 0, 1, 1, 0, 0});
  const TraceTable last = make_table({0, 1, 2, 3, 4, 5, 5}, {0, 0, 1, 1, 0, 0, -9});
  const auto at_first = find_tube_exit(first, reference, make_tube(0.5, 0.1));
  ASSERT_TRUE(at_first);
  EXPECT_EQ(at_first->time_s, 0);
  EXPECT_EQ(at_first->value, 9);
  const auto at_last = find_tube_exit(last, reference, make_tube(0.5, 0.1));
  ASSERT_TRUE(at_last);
  EXPECT_EQ(at_last->time_s, 5);
  EXPECT_EQ(at_last->outside, 8.5);
  // Where the reference jumps so too, they are no fault.
  EXPECT_FALSE(find_tube_exit(first, first, make_tube(0.5, 0)));
  EXPECT_FALSE(find_tube_exit(last, last, make_tube(0.5, 0)));
}

TEST(TraceTube, ATraceOfOneRowIsHeld) {
  const TraceTable reference = make_table({1}, {2});
  EXPECT_FALSE(find_tube_exit(make_table({1}, {2.5}), reference, make_tube(0.5, 0)));
  const auto exit = find_tube_exit(make_table({1}, {2.5 + just}), reference, make_tube(0.5, 0));
  ASSERT_TRUE(exit);
  EXPECT_EQ(exit->limit, 2.5);
}

TEST(TraceTube, ATraceThatStartsElsewhereIsOutside) {
  const TraceTable reference = make_reference();
  const TraceTable late = make_table({0.5, 1, 2, 3, 4, 5}, {0, 0, 1, 1, 0, 0});
  EXPECT_FALSE(find_tube_exit(late, reference, make_tube(0.1, 0.5)));
  for (const bool swapped : {false, true}) {
    const auto exit = swapped ? find_tube_exit(reference, late, make_tube(0.1, 0.4))
                              : find_tube_exit(late, reference, make_tube(0.1, 0.4));
    ASSERT_TRUE(exit);
    EXPECT_TRUE(exit->is_start);
    EXPECT_FALSE(exit->is_end);
    EXPECT_EQ(exit->value, swapped ? 0 : 0.5);
  }
}

TEST(TraceTube, ARelativeHeightIsAShareOfWhatTheReferenceSpans) {
  const TraceTable reference = raised(make_reference(), 100);  // spans 1, is about 100
  EXPECT_FALSE(find_tube_exit(raised(reference, 0.125), reference, make_tube(0, 0, 0.125)));
  EXPECT_TRUE(find_tube_exit(raised(reference, 0.126), reference, make_tube(0, 0, 0.125)));
}

TEST(TraceTube, AThinnedTraceHoldsItsOriginalWithinATenthOfTheTube) {
  TraceTable full;
  full.columns.resize(1);
  for (int i = 0; i <= 2000; ++i) {
    const double t = 0.001 * i;
    full.time_s.push_back(t);
    full.columns[0].push_back(std::sin(2 * std::numbers::pi * t) + (t >= 1 ? 0.5 : 0));
  }
  // A jump: the instant stands twice.
  full.time_s.insert(full.time_s.begin() + 1000, 1.0);
  full.columns[0].insert(full.columns[0].begin() + 1000, full.columns[0][1000] - 0.5);
  const TraceExpectation tube = make_tube(0.01, 0);
  const TraceTable thin = thin_trace(full, tube);
  // A chord of a sine that is wrong by 0.001 at most is 14 ms long.
  EXPECT_LT(thin.time_s.size(), 200U);
  EXPECT_EQ(thin.time_s.front(), 0);
  EXPECT_EQ(thin.time_s.back(), 2);
  // Rounding of the last digit beside a tenth of 0.01.
  EXPECT_FALSE(find_tube_exit(full, thin, make_tube(0.001 + 1e-12, 0)));
  EXPECT_TRUE(find_tube_exit(full, thin, make_tube(0.0005, 0)));  // it is thinned at all
}

}  // namespace
}  // namespace gyrator
