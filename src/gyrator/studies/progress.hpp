#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>

namespace gyrator {

/// A progress bar with rate and time left on stderr.
///
///     Progress progress("Z-width map", designs.size(), quiet);
///     for (…) { …; progress.advance(); }
///
/// Draws only where stderr is a terminal, `quiet` is false and the work has lasted over a second;
/// the destructor wipes the line. advance() may be called from many threads.
class Progress {
 public:
  /// `total` counts the steps of the whole work; 0 where it is not known (no bar then, but count
  /// and rate).
  Progress(std::string title, std::uint64_t total, bool quiet = false);
  ~Progress();

  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  Progress(Progress&&) = delete;
  Progress& operator=(Progress&&) = delete;

  void advance(std::uint64_t steps = 1);

 private:
  using Clock = std::chrono::steady_clock;
  void draw(std::uint64_t done, Clock::time_point now);

  std::string title_;
  std::uint64_t total_;
  bool visible_;
  Clock::time_point start_ = Clock::now();
  std::atomic<std::uint64_t> done_{0};
  std::atomic<Clock::rep> next_draw_;  // ticks of Clock; read before the lock is tried
  std::mutex drawing_;
  bool drawn_ = false;
};

/// One line of the bar, at most `width` columns wide, without line break:
/// "title [####      ]  40 %  12.3/s  0:42 left". `total` 0 means unknown.
std::string progress_line(const std::string& title, std::uint64_t done, std::uint64_t total,
                          double elapsed_s, std::size_t width);

}  // namespace gyrator
