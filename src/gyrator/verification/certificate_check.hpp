#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/mechanics/device.hpp"
#include "gyrator/verification/held_device.hpp"

#include <complex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace gyrator {

/// One interval of a certificate, |w - omega| <= reach, over which it claims
///   D >= margin - |slope| reach - curvature reach^2 > 0.                              (vc-1)
struct CertifiedInterval {
  double omega = 0, reach = 0;   ///< [rad/s]
  std::complex<double> law;      ///< H at the middle
  std::complex<double> center;   ///< of the disk there
  double radius = 0;             ///< with what the sums leave out
  double margin = 0, slope = 0;  ///< D and dD/dw there
  double curvature = 0;
};

/// A loop that is claimed to be passive.
struct CertifiedLoop {
  DiscreteStateSpace law;
  double uncoupled_spectral_radius = 0;
  double lowest_omega = 0, lowest_margin = 0;
  std::vector<CertifiedInterval> intervals;
};

/// What is claimed to break a loop.
struct OperatorRefutation {
  MassSpringDamper held_by;
  double spectral_radius = 0, frequency_hz = 0;
};
struct UncoupledRefutation {
  double spectral_radius = 0;
};
struct DeviceRefutation {
  double omega = 0, damping = 0;
};
struct DiskRefutation {
  double omega = 0;
  std::complex<double> law, center;
  double radius = 0, margin = 0;
};
using Refutation =
    std::variant<OperatorRefutation, UncoupledRefutation, DeviceRefutation, DiskRefutation>;

/// A field that is not what was found.
struct Discrepancy {
  std::string field;   ///< "intervals/omega/17"
  std::string reason;  ///< "recorded 1.2: found 1.3"
};

/// What was found of a loop, whatever the certificate says.
struct CheckedLoop {
  int intervals = 0;                ///< recorded
  int enclosures = 0;               ///< of the checker's own
  double smallest_margin = 0;       ///< D is nowhere less, by the checker's own enclosures
  bool to_zero = false;             ///< down to zero frequency itself
  double tightest = 0, widest = 0;  ///< recorded over true radius, least and most
  double spectral_radius = 0;
};

/// The recorded radius holds the true disk and is at most this much larger, and 2e-5 of the centre.
inline constexpr double largest_reserve = 1.01;

/// Everything that a passive loop claims: stable with nothing attached, the intervals cover
/// (0, pi/T], every disk, margin and slope, and D > 0 between, proved again. Stops at the first few
/// discrepancies.
std::vector<Discrepancy> check_passive_loop(const HeldDevice& device, const Sampling& sampling,
                                            const CertifiedLoop& loop, CheckedLoop& found);

/// That the loop is not passive, for the reason given.
std::vector<Discrepancy> check_refutation(const HeldDevice& device, const Sampling& sampling,
                                          const DiscreteStateSpace& law,
                                          const Refutation& refutation);

/// Sizes that fit, finite numbers, a port that has inertia.
std::vector<Discrepancy> check_device_shape(const HeldDevice& device);

}  // namespace gyrator
