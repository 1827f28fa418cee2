#include "gyrator/core/random_stream.hpp"

#include <cmath>

namespace gyrator {
namespace {

// The output function of splitmix64 (Steele, Lea and Flood 2014): neighbouring seeds become
// unrelated ones.
std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31U);
}

constexpr std::uint64_t golden = 0x9e3779b97f4a7c15U;

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t stream)
    : engine_(mix(mix(seed + golden) + stream * golden)) {}

double RandomStream::uniform() {
  return static_cast<double>(engine_() >> 11U) * 0x1p-53;
}

std::int64_t RandomStream::symmetric_integer(std::int64_t largest) {
  const auto count = static_cast<double>(2 * largest + 1);
  return static_cast<std::int64_t>(std::floor(uniform() * count)) - largest;
}

double RandomStream::normal() {
  constexpr double half_width = 0.857763884960706796480;  // sqrt(2/e)
  for (;;) {
    const double u = 1 - uniform();
    const double ratio = half_width * (2 * uniform() - 1) / u;
    if (ratio * ratio <= -4 * std::log(u)) return ratio;
  }
}

}  // namespace gyrator
