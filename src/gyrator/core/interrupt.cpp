#include "gyrator/core/interrupt.hpp"

#include "gyrator/core/error.hpp"

#include <atomic>
#include <csignal>
#include <string>

namespace gyrator {
namespace {

// A signal handler can reach nothing but a static; only the functions of this file see it.
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "only lock-free atomics may be used here");

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
}

}  // namespace gyrator
