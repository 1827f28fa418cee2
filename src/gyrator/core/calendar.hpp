#pragma once

#include "gyrator/core/rational.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace gyrator {

/// Something that happens at offset + k period [s], k = 0, 1, 2, …
struct PeriodicTask {
  std::string name;
  Rational period;
  Rational offset = 0;
};

/// Goes through the instants of several periodic tasks in order, in exact time.
///
///   t(k) = offset + k period                                          (calendar-1)
///
/// is computed from k at each tick and never accumulated: tasks of 200 Hz and 60 Hz meet every
/// 50 ms for ever. Tasks that tick at the same instant come fast before slow (shorter period
/// first), then in the order of declaration. A copy goes on by itself from where the original
/// stands.
class Calendar {
 public:
  struct Tick {
    std::size_t task = 0;    ///< index into tasks()
    std::int64_t index = 0;  ///< k
  };
  struct Instant {
    Rational time;                ///< [s]
    std::span<const Tick> ticks;  ///< in order of execution; valid until next() or the end of this
  };

  /// Throws bad_input, with the task's name as place, for a period ≤ 0, a negative offset, or a
  /// calendar without tasks.
  explicit Calendar(std::vector<PeriodicTask> tasks);

  const std::vector<PeriodicTask>& tasks() const { return tasks_; }

  /// When next() will be [s].
  Rational peek() const;
  /// The next instant with every task that ticks there; allocates nothing. Throws numerical when
  /// the time after it no longer fits a Rational.
  Instant next();

 private:
  std::vector<PeriodicTask> tasks_;
  std::vector<std::size_t> order_;   // of the tasks: fast before slow, then as declared
  std::vector<std::int64_t> index_;  // k of each task's next tick
  std::vector<Rational> due_;        // and its time
  std::vector<Tick> ticks_;          // of the instant given last, at the front
};

}  // namespace gyrator
