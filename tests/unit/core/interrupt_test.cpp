#include "gyrator/core/interrupt.hpp"

#include "gyrator/core/error.hpp"

#include <array>
#include <csignal>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr std::array signals{SIGINT, SIGTERM, SIGHUP};

// What the signals did before goes back.
class Interrupt : public testing::Test {
 protected:
  Interrupt() {
    for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], nullptr, &before_[i]);
  }
  ~Interrupt() override {
    for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &before_[i], nullptr);
    acknowledge_interrupt();
  }
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  Interrupt(Interrupt&&) = delete;
  Interrupt& operator=(Interrupt&&) = delete;

 private:
  std::array<struct sigaction, signals.size()> before_{};
};

TEST_F(Interrupt, each_signal_sets_the_flag) {
  for (const int each : signals) {
    install_interrupt_handler();
    ASSERT_EQ(std::raise(each), 0);
    EXPECT_TRUE(interrupt_requested()) << each;
    EXPECT_THROW(throw_if_interrupted("here"), Error);
    acknowledge_interrupt();
  }
}

TEST_F(Interrupt, a_closing_terminal_may_say_so_twice) {
  install_interrupt_handler();
  for (const int each : {SIGTERM, SIGTERM, SIGHUP, SIGHUP}) ASSERT_EQ(std::raise(each), 0);
  EXPECT_TRUE(interrupt_requested());
}

TEST_F(Interrupt, an_ignored_hangup_stays_ignored) {
  std::signal(SIGHUP, SIG_IGN);
  install_interrupt_handler();
  ASSERT_EQ(std::raise(SIGHUP), 0);
  EXPECT_FALSE(interrupt_requested());
}

TEST_F(Interrupt, a_shield_answers_with_a_line_and_no_more) {
  install_interrupt_handler();
  ASSERT_EQ(std::raise(SIGINT), 0);  // the next one would end the process
  {
    const InterruptShield shield;
    EXPECT_FALSE(interrupt_requested()) << "what came before counts as heard";
    testing::internal::CaptureStderr();
    {
      const InterruptShield inner;
      ASSERT_EQ(std::raise(SIGINT), 0);
    }
    ASSERT_EQ(std::raise(SIGINT), 0);
    ASSERT_EQ(std::raise(SIGTERM), 0);
    EXPECT_NE(testing::internal::GetCapturedStderr().find("one moment"), std::string::npos);
    EXPECT_FALSE(interrupt_requested());
  }
  ASSERT_EQ(std::raise(SIGTERM), 0);
  EXPECT_TRUE(interrupt_requested()) << "afterwards it is as before";
}

}  // namespace
}  // namespace gyrator
