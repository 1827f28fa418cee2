#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

TEST(TimeLimit, stops_work_at_the_first_safe_point_after_it) {
  const TimeLimit limit(0.02);
  EXPECT_NO_THROW(throw_if_interrupted("here"));
  EXPECT_FALSE(limit.has_stopped());
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  try {
    throw_if_interrupted("here");
    FAIL() << "went on";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::numerical);
    EXPECT_EQ(error.place(), "here");
  }
  EXPECT_TRUE(limit.has_stopped());
}

TEST(TimeLimit, ends_with_its_scope_and_binds_no_other_thread) {
  {
    const TimeLimit limit(1e-9);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::thread([] { EXPECT_NO_THROW(throw_if_interrupted("elsewhere")); }).join();
    EXPECT_THROW(throw_if_interrupted("here"), Error);
  }
  EXPECT_NO_THROW(throw_if_interrupted("after"));
  const TimeLimit none(std::nullopt);
  EXPECT_NO_THROW(throw_if_interrupted("without"));
}

}  // namespace
}  // namespace gyrator
