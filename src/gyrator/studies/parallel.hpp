#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace gyrator {

/// Calls body(0) … body(count - 1), each once, in any order on `threads` cores (0: all). What the
/// first of them that fails throws is thrown here, after the others have stopped.
void run_parallel(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

/// While it lives, no more than so many threads work in this process, whatever is asked for.
class ThreadLimit {
 public:
  /// 0: no limit.
  explicit ThreadLimit(int threads);
  ~ThreadLimit();

  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
  ThreadLimit(ThreadLimit&&) = delete;
  ThreadLimit& operator=(ThreadLimit&&) = delete;

 private:
  struct Control;
  std::unique_ptr<Control> control_;
};

/// The environment variable that limits a process's threads, for programs that start several.
inline constexpr const char* threads_variable = "GYRATOR_THREADS";
/// Its value; 0 where it is not set or no number from 1 to 1024.
int read_threads_variable();

}  // namespace gyrator
