#pragma once

#include <complex>
#include <span>

namespace gyrator {

/// What else than the sine a signal holds, and is fitted with it.
struct SineModel {
  int harmonics = 1;     ///< up to this multiple of the frequency; friction makes odd ones
  int drift_degree = 1;  ///< of the polynomial in time beside them
};

/// A sine in a sampled signal,
///   x(t) = Re(C e^{j 2 pi f t}) + harmonics + drift + error.                         (sine-1)
struct SineFit {
  std::complex<double> coefficient;  ///< C, in the signal's unit; t counts as `start` does
  double deviation = 0;              ///< standard one of Re C, and of Im C
  double residual = 0;               ///< root mean square of what is left
  double peak_to_peak = 0;           ///< of the whole signal
};

/// Fits the sine by least squares. The deviation comes from the residual in ten blocks, so that an
/// error that is not white (quantization, a drift that is no polynomial) counts as what it does to
/// C:
///   r_b = (2/N) sum over block b of r_k e^{-j 2 pi f t_k},   s^2 = sum |r_b|^2/2 · 10/9.  (sine-2)
/// `start` is the time of the first sample, `period` between samples [s]. Throws numerical for
/// fewer samples than twice the unknowns.
SineFit fit_sine(std::span<const double> signal, double start, double period, double frequency_hz,
                 const SineModel& model = {});

}  // namespace gyrator
