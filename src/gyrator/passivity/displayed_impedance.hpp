#pragma once

#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/port_response.hpp"

#include <complex>
#include <optional>

namespace gyrator {

/// What the sampled loop looks like from the port at one frequency, whatever its law H.
struct DisplayedLoop {
  double omega = 0;           ///< [rad/s]
  std::complex<double> bare;  ///< Z: without a command [N.s/m, N.m.s/rad]
  std::complex<double> path;  ///< S A k_0: from the law to the impedance [s]
  std::complex<double>
      blocked;  ///< m = sum_n k_n M_n: the loop that stays with the port held [m/N]

  /// Z_cl of (displayed-1) for the law's response H at this frequency.
  std::complex<double> displayed(std::complex<double> law) const {
    return bare + path * law / (1.0 + law * blocked);
  }
};

/// The impedance that a sampled loop displays to the hand [N.s/m, N.m.s/rad]: with the port's
/// velocity v e^(jwt) imposed, the fundamental of the effort at the port over v,
///   Z_cl(jw) = Z + S A H k_0 / (1 + H m),   m = sum_n k_n M(jw_n)                  (displayed-1)
///   k_n = (1 - e^(-jwT)) e^(-jw_n t_d) / (T (jw_n)^2),   w_n = w + n 2 pi/T
/// Z, A, S, M of (port-1), H(z) the opposing law, T period and t_d delay [s]. The sampled signal is
/// S v/(jw) and what the command itself moves with the port held, all aliases of it: that is m,
/// zero where the sensor sees the port, and here the exact pulse response of the held plant. Of the
/// held command only the fundamental, k_0 jw, is counted; the effort at w + n 2 pi/T leaves the
/// port, too, but finds no such velocity and does no work on the average.
/// Holds below Nyquist, 0 < w < pi/T, for a loop that is stable with its port held. A wall that
/// the exact disk calls passive has Re Z_cl > 0: with a hand that lets no alias move, (disk-2)
/// is that.
class DisplayedImpedance {
 public:
  /// Throws as sample_plant and PortModel do.
  DisplayedImpedance(const Device& device, const Sampling& sampling);

  DisplayedLoop at(double omega);

 private:
  std::complex<double> sum_blocked(double omega) const;

  PortModel model_;
  double period_;
  double delay_;
  std::optional<SampledPlant> held_;  ///< none where the sensor sees the port
};

}  // namespace gyrator
