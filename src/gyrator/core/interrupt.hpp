#pragma once

#include <chrono>
#include <optional>
#include <string_view>

namespace gyrator {

/// Turns Ctrl-C (SIGINT), SIGTERM and SIGHUP into a flag that long work looks at; to be called
/// once, in main.
///
/// The first SIGINT only sets the flag, so that destructors run and no half-written file stays;
/// the second one ends the process as usual. SIGTERM and SIGHUP only set it however often they
/// come, since a closing terminal and timeout(1) send them twice. A SIGHUP that is ignored, as
/// under nohup, stays so. Blocking system calls return with EINTR.
void install_interrupt_handler();

/// True once one of these signals has come (after install_interrupt_handler).
bool interrupt_requested();

/// From here on a Ctrl-C counts as heard: what was done until then can be written. Another one
/// still ends the process.
void acknowledge_interrupt();

/// Throws Error interrupted ("place: interrupted") once the user has pressed Ctrl-C, and numerical
/// once the time of this thread's TimeLimit is over.
/// Call it at safe points: between designs of a map, samples of a run, rows of a file.
void throw_if_interrupted(std::string_view place);

/// While one lives, SIGINT, SIGTERM and SIGHUP do nothing but write a line to stderr: for what must
/// not be left half done, such as switching a drive off. What came before counts as heard.
class InterruptShield {
 public:
  InterruptShield();
  ~InterruptShield();

  InterruptShield(const InterruptShield&) = delete;
  InterruptShield& operator=(const InterruptShield&) = delete;
  InterruptShield(InterruptShield&&) = delete;
  InterruptShield& operator=(InterruptShield&&) = delete;
};

/// What this thread computes while the object lives may take so long [s], and is stopped at the
/// first safe point after it. One at a time in a thread; work handed to other threads is not
/// counted.
class TimeLimit {
 public:
  /// None: no limit.
  explicit TimeLimit(std::optional<double> seconds);
  ~TimeLimit();

  TimeLimit(const TimeLimit&) = delete;
  TimeLimit& operator=(const TimeLimit&) = delete;
  TimeLimit(TimeLimit&&) = delete;
  TimeLimit& operator=(TimeLimit&&) = delete;

  /// Whether something was stopped for it.
  bool has_stopped() const { return stopped_; }

 private:
  friend void throw_if_interrupted(std::string_view place);

  std::optional<double> seconds_;
  std::chrono::steady_clock::time_point end_;
  bool stopped_ = false;
};

}  // namespace gyrator
