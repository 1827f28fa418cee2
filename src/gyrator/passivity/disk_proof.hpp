#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"
#include "gyrator/controllers/sampling.hpp"
#include "gyrator/passivity/port_response.hpp"

#include <complex>
#include <vector>

namespace gyrator {

/// One interval of base frequencies over which D of (disk-3) is proved positive:
///   D >= margin - |slope| h - curvature h^2 > 0,   h half the interval's width.
struct ProvedInterval {
  double omega = 0;             ///< its middle [rad/s]
  double reach = 0;             ///< h [rad/s]
  std::complex<double> law;     ///< H at the middle
  std::complex<double> center;  ///< of the disk at the middle, c of (disk-1)
  double radius = 0;            ///< r of it or more, with what the sums leave out
  double margin = 0;            ///< D at the middle, or less [N.s/m, N.m.s/rad]
  double slope = 0;             ///< dD/dw there
  double curvature = 0;         ///< bound on the rest
  double lowest() const { return margin - (std::abs(slope) + curvature * reach) * reach; }
};

enum class ProofOutcome {
  proved,    ///< D > 0 at every frequency
  violated,  ///< D <= 0 at `omega`
  undecided  ///< too close to zero at `omega` for the arithmetic
};

/// What is known of D > 0 over all base frequencies 0 < w <= pi/T, and of Re Z > 0 there and above.
struct DiskProof {
  ProofOutcome outcome = ProofOutcome::undecided;
  double omega = 0;     ///< where it is violated or undecided [rad/s]
  double margin = 0;    ///< D there; where proved, the lowest bound over all intervals
  bool active = false;  ///< it is Re Z itself, the bare device's, that is not above zero there
  std::vector<ProvedInterval> intervals;  ///< from high to low frequency, touching one another
  double lowest_omega = 0;  ///< lower end of the last: below, D is even in w and analytic, and has
                            ///< reached its limit
  int aliases = 0;          ///< summed one by one on either side
  int bounded_aliases = 0;  ///< and up to here with a bound of their own
  int evaluations = 0;
};

/// Proves |1 + H c| > |H| r between the points too. Every term of the sums, the law and their
/// combination is carried as a TaylorModel over an interval; intervals split until D is positive on
/// each, so that a dip however narrow is met. D is grouped as
///   D = R (|W|^2 - |H r_a|^2) + Re{W* L} - |L| |H r_a|,  W = 1 + H (k_0 M + c_a),  L = H k_0 S A
///                                                                                    (proof-1)
/// with R = Re Z, k_0 the base weight and c_a, r_a centre and radius of all aliases but the base
/// one. L has a pole at zero frequency whose residue is real and says nothing of D; it is taken out
/// before anything is bounded.
///
/// Aliases up to `aliases` follow the frequency in each interval; those up to `bounded_aliases` are
/// cubics in it over the whole base range, whose remainders are added to the radius; beyond,
/// the tail's integral with 0.02 % of itself as a reserve (its oscillating centre under a
/// fractional delay: all of it). Rounding is allowed for with 10^-11 of the terms' sizes.
DiskProof prove_disk(PortModel& model, const Sampling& sampling, const DiscreteStateSpace& law);

}  // namespace gyrator
