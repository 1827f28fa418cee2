#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdlib>

// Counts every allocation of the program: Eigen and C libraries call malloc, and so does the
// standard library's operator new. To be included by one source of a test program only. The
// sanitizers bring a malloc of their own: nothing is counted under them.
#if defined(__SANITIZE_ADDRESS__) || !defined(__GLIBC__)
#define GYRATOR_COUNTS_ALLOCATIONS 0
#else
#define GYRATOR_COUNTS_ALLOCATIONS 1
#endif

namespace gyrator::testing {

/// Allocations by this thread since it started.
inline thread_local long allocations = 0;

}  // namespace gyrator::testing

#if GYRATOR_COUNTS_ALLOCATIONS
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) noexcept {
  ++gyrator::testing::allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++gyrator::testing::allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) noexcept {
  ++gyrator::testing::allocations;
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++gyrator::testing::allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** where, std::size_t alignment, std::size_t size) noexcept {
  ++gyrator::testing::allocations;
  *where = __libc_memalign(alignment, size);
  return *where ? 0 : ENOMEM;
}
}
#endif
