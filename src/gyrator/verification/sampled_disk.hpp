#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/verification/held_device.hpp"

#include <complex>
#include <vector>

namespace gyrator {

/// The aliased disk at one frequency, (disk-1) of docs/passivity.md.
struct SampledDiskPoint {
  using Complex = std::complex<long double>;
  long double omega = 0;
  long double damping = 0;  ///< Re Z
  Complex center;
  long double radius = 0;
  long double error = 0;  ///< of centre and radius together, estimated
  // Base term and aliases apart, for a margin without a difference of large numbers.
  Complex path;          ///< k_0 S A
  Complex other_center;  ///< centre without k_0 S A/(2 Re Z)
  long double other_radius = 0;

  /// D = Re Z (|1 + H c|^2 - |H r|^2)
  ///   = Re Z (|W|^2 - |H r_a|^2) + Re{W* L} - |L| |H| r_a,  W = 1 + H c_a, L = H k_0 S A  (vd-1)
  long double margin(Complex law) const;
  /// The sizes of its terms, added.
  long double margin_terms(Complex law) const;
};

/// The disk by brute force: every response a dense solve in extended precision, aliases summed one
/// by one, from the 33rd on the response as a polynomial in 1/omega whose sums are Hurwitz zeta
/// functions,
///   sum over n >= N of (omega + n rate)^-k = rate^-k zeta(k, N + omega/rate)             (vd-2)
/// and with a delay that is no whole number of periods 2000 of them one by one, the rest by parts.
class SampledDisk {
 public:
  SampledDisk(const HeldDevice& device, const Sampling& sampling);
  SampledDiskPoint at(long double omega) const;

 private:
  using Complex = std::complex<long double>;
  struct Alias {
    Complex center;          // M + S A/(2 Re Z)
    long double radius = 0;  // |S A|/(2 Re Z)
  };
  struct Panel {
    int first = 0, last = 0;  // last = 0: to infinity
    std::vector<Complex> center;
    std::vector<long double> radius;  // polynomials in (first - 1/2) rate/omega; none: one by one
    long double error = 0;
  };
  Alias alias_at(long double omega) const;
  Panel fit(int first, int last) const;
  void add_panels(int first, int last, int depth);
  Alias evaluate(const Panel& panel, long double omega) const;
  void add_tail(long double omega, SampledDiskPoint& point, Complex& center,
                long double& radius) const;

  HeldDevice device_;
  long double period_, rate_, delay_;
  Complex turn_;  // e^(-j rate delay): from one alias to the next
  bool whole_delay_;
  std::vector<Panel> panels_;
};

}  // namespace gyrator
