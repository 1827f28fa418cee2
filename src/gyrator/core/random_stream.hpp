#pragma once

#include <cstdint>
#include <random>

namespace gyrator {

/// Random numbers that are the same with every standard library, but for a last digit of std::log.
///
/// The bits are those of std::mt19937_64, which the standard fixes, seeded with a mix (splitmix64)
/// of `seed` and `stream`, so that streams of one seed have nothing to do with each other. The
/// standard's distributions are not fixed and are not used:
///   uniform: the upper 53 bits of one draw, times 2^-53
///   normal:  ratio of uniforms (Kinderman and Monahan 1977): v/u with u in (0, 1] and
///            v in ± sqrt(2/e), accepted for (v/u)^2 <= -4 ln u. A number is one division; the
///            logarithm only decides about taking it: rounded otherwise, it might, very
///            rarely, take another one.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream);

  /// In [0, 1).
  double uniform();
  /// An integer in [-largest, largest], each as likely as the other (to 2^-53).
  std::int64_t symmetric_integer(std::int64_t largest);
  /// Mean 0, standard deviation 1.
  double normal();

 private:
  std::mt19937_64 engine_;
};

}  // namespace gyrator
