#include "gyrator/core/interrupt.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <string>
#include <unistd.h>

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

constexpr std::array signals{SIGINT, SIGTERM, SIGHUP};

// What the signals did before the first of the shields; shields are made and end in one thread.
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
std::array<struct sigaction, signals.size()> unshielded{};
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
int shields = 0;

extern "C" void note_interrupt(int) {
  interrupted.store(true);
}

extern "C" void ask_for_patience(int) {
  const int kept = errno;
  static constexpr std::string_view text =
      "gyrator: the device is being made safe and its settings put back: one moment, please\n";
  // To nobody, where stderr is gone.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text.data(), text.size());
  errno = kept;
}

void handle(int signal, void (*handler)(int), int flags) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  action.sa_flags = flags;
  sigaction(signal, &action, nullptr);
}

bool is_ignored(int signal) {
  struct sigaction now {};
  return sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

}  // namespace

void install_interrupt_handler() {
  handle(SIGINT, note_interrupt, static_cast<int>(SA_RESETHAND));  // the second one ends it
  handle(SIGTERM, note_interrupt, 0);
  if (!is_ignored(SIGHUP)) handle(SIGHUP, note_interrupt, 0);
}

InterruptShield::InterruptShield() {
  if (shields++ > 0) return;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    sigaction(signals[i], nullptr, &unshielded[i]);
    handle(signals[i], ask_for_patience, SA_RESTART);
  }
  acknowledge_interrupt();
}

InterruptShield::~InterruptShield() {
  if (--shields > 0) return;
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &unshielded[i], nullptr);
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
