#include "gyrator/core/calendar.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace gyrator {

Calendar::Calendar(std::vector<PeriodicTask> tasks)
    : tasks_(std::move(tasks)),
      order_(tasks_.size()),
      index_(tasks_.size(), 0),
      ticks_(tasks_.size()) {
  if (tasks_.empty()) throw Error(ErrorCode::bad_input, "calendar", "it has no task");
  for (const PeriodicTask& task : tasks_) {
    if (task.period <= 0) {
      throw Error(ErrorCode::bad_input, task.name,
                  "period " + task.period.to_string() + " s: it must be above 0");
    }
    if (task.offset < 0) {
      throw Error(ErrorCode::bad_input, task.name,
                  "offset " + task.offset.to_string() + " s: it must not be negative");
    }
    due_.push_back(task.offset);
  }
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::stable_sort(order_.begin(), order_.end(), [this](std::size_t a, std::size_t b) {
    return tasks_[a].period < tasks_[b].period;
  });
}

Rational Calendar::peek() const {
  return *std::min_element(due_.begin(), due_.end());
}

Calendar::Instant Calendar::next() {
  const Rational now = peek();
  std::size_t count = 0;
  for (const std::size_t task : order_) {
    if (due_[task] != now) continue;
    ticks_[count++] = {task, index_[task]};
    const std::int64_t k = ++index_[task];
    due_[task] = tasks_[task].offset + Rational(k) * tasks_[task].period;  // calendar-1
  }
  return {now, std::span<const Tick>(ticks_).first(count)};
}

}  // namespace gyrator
