#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/port_response.hpp"

#include <complex>
#include <optional>
#include <vector>

namespace gyrator {

/// All loop responses y/u that passive operators can bring about at one frequency: a disk.
///
/// A passive operator Σ (Re Σ >= 0) gives 1/(Z + Σ) anywhere in the disk of centre and radius
/// 1/(2 Re Z). The hold and the sampler add the aliases w_n = w + n w_s, at each of which the
/// operator may act differently, so centres and radii add:
///   c = sum_n k_n (M + S A/(2 Re Z))(jw_n)      r = sum_n |k_n| |S A|/(2 Re Z)(jw_n)   (disk-1)
///   k_n = (1 - e^(-jwT)) e^(-jw_n t_d) / (T (jw_n)^2)
/// The loop 1 + H y/u is stable with every passive operator if it is with none and
///   |1 + H c| > |H| r     for 0 < w <= pi/T.                                            (disk-2)
/// Multiplied out, with |c| and r nearly equal at low frequency, that is the sign of
///   D = Re Z + 2 Re{H Re Z c} + |H|^2 Re Z (|c|^2 - r^2)                                (disk-3)
/// which is a damping [N.s/m, N.m.s/rad]: for A = 1 and constant Re Z = b it is exactly b + b_v.
/// The parts are kept such that no large terms cancel and Re Z may be zero.
struct DiskPoint {
  double omega = 0;                    ///< [rad/s]
  double damping = 0;                  ///< Re Z(jw)
  std::complex<double> center;         ///< c [m/N, rad/N.m]; infinite where Re Z = 0
  double radius = 0;                   ///< r; infinite where an alias has no damping at all
  std::complex<double> scaled_center;  ///< Re Z c
  double scaled_gap = 0;               ///< Re Z (|c|^2 - r^2)

  /// D of (disk-3) for the law's response H at this frequency.
  double damping_margin(std::complex<double> law) const {
    if (law == 0.0) return damping;  // the gap may be infinite
    return damping + 2 * std::real(law * scaled_center) + std::norm(law) * scaled_gap;
  }
};

/// Sums the aliases for a device under given sampling. Direct terms up to beyond every resonance,
/// then Euler–Maclaurin with Gauss quadrature of the smooth tail, closed by its power law. Where
/// the delay is not a whole number of periods the centre's tail oscillates; it is cut and its
/// bound added to the radius, on the safe side.
class AliasedDisk {
 public:
  /// `correction` changes what the model says of the port, at base frequencies and aliases alike;
  /// it must tend to none at high frequency, where the tail is closed by the model's power law.
  AliasedDisk(const Device& device, const Sampling& sampling, PortCorrection correction = {});

  /// The disk at a base frequency, with `extra_damping` added at the port (a damper there changes
  /// Re Z alone, at every alias).
  DiskPoint at(double omega, double extra_damping = 0);

  /// Everything the sums at one frequency consist of, to be evaluated for many extra dampings.
  struct Terms;
  Terms collect(double omega);
  DiskPoint evaluate(const Terms& terms, double extra_damping) const;

  PortModel& model() { return model_; }
  double period() const { return period_; }
  int direct_aliases() const { return aliases_; }

  /// The lowest Re Z met so far and where, over base frequencies and aliases.
  struct LeastDamping {
    double omega = 0;
    double value = 0;
    bool active = false;  ///< negative beyond rounding: the bare device supplies energy there
  };
  const LeastDamping& least_damping() const { return least_; }

  struct Term {
    std::complex<double> center_weight;  // k_n, or its part of a quadrature
    double radius_weight = 0;
    std::complex<double> path;     // S A
    std::complex<double> blocked;  // M, at aliases and in the tail less what it tends to
    double damping = 0;            // Re Z
  };
  struct Terms {
    double omega = 0;
    Term base;
    std::complex<double> feedthrough;  // of the command into the sensed signal, all aliases
    std::complex<double> tail_factor;  // of the shared tail's upper (conjugated: lower) half
    std::vector<Term> aliases;
  };

 private:
  Term make_term(double omega);
  std::complex<double> sum_feedthrough(double omega, std::complex<double> base_weight) const;
  void note_damping(const PortResponse& response);
  void prepare_tail();
  /// The integral behind the direct terms, without its factor: centre, its terms' sizes, radius.
  struct Tail {
    std::complex<double> center;
    double size = 0, radius = 0;
  };
  Tail sum_tail(double extra_damping) const;

  PortModel model_;
  PortCorrection correction_;
  double period_;
  double delay_;
  SplitDelay split_;
  bool whole_delay_;
  int aliases_;
  double tail_start_ = 0;   // [rad/s]
  std::vector<Term> tail_;  // quadrature of the integral from tail_start_, weights for 1/w^2
  Tail bare_tail_;          // without extra damping
  Term far_, farther_;      // the power law behind the last panel is read off these two
  double far_omega_ = 0;
  LeastDamping least_;
};

}  // namespace gyrator
