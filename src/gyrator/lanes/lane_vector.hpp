#pragma once

// Vectors of double of the width that this file is compiled for. Everything has internal linkage:
// a function compiled for a wide instruction set must not be taken for the common one.

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace {

#if defined(__AVX512F__)
constexpr int vector_width = 8;
#elif defined(__AVX2__)
constexpr int vector_width = 4;
#else
constexpr int vector_width = 2;
#endif

typedef double Vector __attribute__((vector_size(8 * vector_width)));
typedef long long Mask __attribute__((vector_size(8 * vector_width)));

// Memory is written and read as numbers, too.
typedef double VectorInMemory __attribute__((vector_size(8 * vector_width), may_alias));

inline Vector load(const double* from) {
  return *reinterpret_cast<const VectorInMemory*>(from);
}
inline void store(double* to, Vector v) {
  *reinterpret_cast<VectorInMemory*>(to) = v;
}
inline Vector broadcast(double v) {
#if defined(__AVX512F__)
  return Vector{v, v, v, v, v, v, v, v};
#elif defined(__AVX2__)
  return Vector{v, v, v, v};
#else
  return Vector{v, v};
#endif
}
inline Vector keep_where(Mask mask, Vector v) {
  return (Vector)((Mask)v & mask);
}
inline Vector select(Mask mask, Vector yes, Vector no) {
  return mask ? yes : no;
}

// Bit i: lane i of the mask.
inline unsigned bits_of(Mask mask) {
#if defined(__AVX512F__)
  return _mm512_movepi64_mask((__m512i)mask);
#elif defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_pd((__m256d)mask));
#elif defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_pd((__m128d)mask));
#else
  return (mask[0] != 0 ? 1U : 0U) | (mask[1] != 0 ? 2U : 0U);
#endif
}

// a b + c; with one rounding where the instruction set has it.
inline Vector multiply_add(Vector a, Vector b, Vector c) {
#if defined(__AVX512F__)
  return _mm512_fmadd_pd(a, b, c);
#elif defined(__AVX2__)
  return _mm256_fmadd_pd(a, b, c);
#else
  return a * b + c;
#endif
}

inline Vector round_down(Vector v) {
#if defined(__AVX512F__)
  return _mm512_floor_pd(v);
#elif defined(__AVX2__)
  return _mm256_floor_pd(v);
#else
  // Adding 1.5 2^52 rounds to the nearest whole number; from 2^51 on all numbers are whole.
  const Vector shift = broadcast(6755399441055744.0);
  const Vector nearest = (v + shift) - shift;
  const Vector down = nearest - keep_where(nearest > v, broadcast(1));
  const Vector whole = broadcast(2251799813685248.0);
  return select((v < whole) & (v > -whole), down, v);
#endif
}

inline Vector larger(Vector a, Vector b) {
  return select(a > b, a, b);
}
inline Vector smaller(Vector a, Vector b) {
  return select(a < b, a, b);
}
inline Vector magnitude(Vector v) {
  return larger(v, -v);
}

// Numbers below 1e-308 count as zero while one of these lives: they would cost a hundred times as
// much.
class FlushTinyNumbers {
#if defined(__SSE2__)
 public:
  FlushTinyNumbers() : before_(_mm_getcsr()) {
    _mm_setcsr(before_ | 0x8040);
  }
  ~FlushTinyNumbers() {
    _mm_setcsr(before_);
  }
  FlushTinyNumbers(const FlushTinyNumbers&) = delete;
  FlushTinyNumbers& operator=(const FlushTinyNumbers&) = delete;

 private:
  unsigned before_;
#endif
};

}  // namespace
