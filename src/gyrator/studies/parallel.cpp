#include "gyrator/studies/parallel.hpp"

#include <cstdlib>
#include <optional>
#include <string>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace gyrator {

void run_parallel(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  // More threads than cores are allowed too: the answer must not hang on their number.
  std::optional<tbb::global_control> limit;
  if (threads > 0)
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
    });
  });
}

struct ThreadLimit::Control {
  tbb::global_control limit;
};

ThreadLimit::ThreadLimit(int threads) {
  if (threads <= 0) return;
  control_.reset(new Control{tbb::global_control(tbb::global_control::max_allowed_parallelism,
                                                 static_cast<std::size_t>(threads))});
}

ThreadLimit::~ThreadLimit() = default;

int read_threads_variable() {
  const char* text = std::getenv(threads_variable);
  if (text == nullptr) return 0;
  constexpr long most = 1024;
  const long threads = std::strtol(text, nullptr, 10);
  return threads >= 1 && threads <= most ? static_cast<int>(threads) : 0;
}

}  // namespace gyrator
