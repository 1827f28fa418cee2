#include "gyrator/core/child_process.hpp"

#include "gyrator/core/error.hpp"

#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

ChildResult run_shell(const std::string& script, const std::string& greeting = "hello") {
  return run_child({.name = "sh",
                    .arguments = {"-c", script},
                    .input = "",
                    .folder = {},
                    .environment = {{"GREETING", greeting}},
                    .remedy = ""});
}

TEST(ChildProcess, ItsStreamsAndItsExitCodeComeBack) {
  const ChildResult result = run_shell("echo out; echo err >&2; exit 7");
  EXPECT_FALSE(result.succeeded);
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_EQ(result.output, "out\n");
  EXPECT_EQ(result.errors, "err\n");
  EXPECT_TRUE(run_shell("true").succeeded);
}

TEST(ChildProcess, ASignalIsNoExitCode) {
  const ChildResult result = run_shell("kill -9 $$");
  EXPECT_FALSE(result.succeeded);
  EXPECT_EQ(result.exit_code, -1);
}

TEST(ChildProcess, ItsEnvironmentIsThisOneAndWhatIsGiven) {
  EXPECT_EQ(run_shell("echo $GREETING").output, "hello\n");
  EXPECT_NE(run_shell("echo $PATH").output, "\n");
  EXPECT_EQ(run_shell("env | grep -c ^PATH=").output, "1\n");
}

TEST(ChildProcess, SeveralThreadsMayWaitForOneEach) {
  constexpr int count = 8;
  std::vector<std::string> outputs(count);
  std::vector<std::thread> threads;
  for (int i = 0; i < count; ++i) {
    threads.emplace_back([&outputs, i] {
      outputs[static_cast<std::size_t>(i)] = run_shell("echo $GREETING", std::to_string(i)).output;
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (int i = 0; i < count; ++i)
    EXPECT_EQ(outputs[static_cast<std::size_t>(i)], std::to_string(i) + "\n");
}

TEST(ChildProcess, WhatIsNotInstalledIsNamedWithItsRemedy) {
  try {
    run_child({.name = "no-such-program-anywhere",
               .arguments = {},
               .input = "",
               .folder = {},
               .environment = {},
               .remedy = "get it"});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.place(), "no-such-program-anywhere");
    EXPECT_EQ(error.message(), "is not installed, get it");
  }
}

}  // namespace
}  // namespace gyrator
