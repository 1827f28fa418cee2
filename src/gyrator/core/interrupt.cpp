#include "gyrator/core/interrupt.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <string>

#include <fmt/core.h>

namespace gyrator {
namespace {

// A signal handler can reach nothing but a static; only the functions of this file see it.
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "only lock-free atomics may be used here");

// Safe points lie deep in the analyses, which know nothing of limits.
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
thread_local TimeLimit* current_limit = nullptr;

extern "C" void note_interrupt(int) {
  interrupted.store(true);
}

}  // namespace

void install_interrupt_handler() {
  struct sigaction action {};
  action.sa_handler = note_interrupt;
  sigemptyset(&action.sa_mask);
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // the second SIGINT ends the process
  sigaction(SIGINT, &action, nullptr);
}

bool interrupt_requested() {
  return interrupted.load();
}

void acknowledge_interrupt() {
  interrupted.store(false);
}

void throw_if_interrupted(std::string_view place) {
  if (interrupt_requested()) throw Error(ErrorCode::interrupted, std::string(place), "interrupted");
  TimeLimit* limit = current_limit;
  if (limit == nullptr || std::chrono::steady_clock::now() < limit->end_) return;
  limit->stopped_ = true;
  throw Error(ErrorCode::numerical, std::string(place),
              fmt::format("stopped after its time limit of {:g} s", *limit->seconds_));
}

TimeLimit::TimeLimit(std::optional<double> seconds) : seconds_(seconds) {
  if (!seconds_) return;
  constexpr double longest = 1e9;  // [s], what the clock's integers hold with ease
  end_ = std::chrono::steady_clock::now() +
         std::chrono::duration_cast<std::chrono::steady_clock::duration>(
             std::chrono::duration<double>(std::min(*seconds_, longest)));
  current_limit = this;
}

TimeLimit::~TimeLimit() {
  if (current_limit == this) current_limit = nullptr;
}

}  // namespace gyrator
