#pragma once

#include <cstddef>
#include <functional>

namespace gyrator {

/// Calls body(0) … body(count - 1), each once, in any order on `threads` cores (0: all). What the
/// first of them that fails throws is thrown here, after the others have stopped.
void run_parallel(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

}  // namespace gyrator
