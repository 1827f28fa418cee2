#include "gyrator/verification/certificate_check.hpp"

#include "gyrator/core/interrupt.hpp"
#include "gyrator/verification/discrepancies.hpp"
#include "gyrator/verification/margin_enclosure.hpp"
#include "gyrator/verification/sampled_disk.hpp"
#include "gyrator/verification/sampled_loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {

void report(Discrepancies& list, std::string field, std::string reason) {
  list.push_back({std::move(field), std::move(reason)});
}

void compare(Discrepancies& list, const std::string& field, double recorded, double found,
             double tolerance) {
  if (std::abs(recorded - found) <= tolerance) return;
  report(list, field, fmt::format("recorded {:.12g}: found {:.12g}", recorded, found));
}

std::complex<double> narrow(std::complex<long double> z) {
  return {static_cast<double>(z.real()), static_cast<double>(z.imag())};
}

namespace {

using Complex = std::complex<double>;
using Long = long double;
using LongComplex = std::complex<long double>;

constexpr std::size_t enough = 5;         // discrepancies
constexpr double slope_agreement = 2e-3;  // of dD/dw: the reserve in the radius moves too
// Beside what the disk says, of the margin: rounding at the lowest frequencies, where D is what is
// left of terms a million times larger. D > 0 is proved without the recorded margins.
constexpr double small_reserve = 1e-3;
constexpr double center_reserve = 2e-5;  // of the centre, in the radius
constexpr double wanted = 0.8;           // of the recorded lowest margin, before splitting ends
constexpr int deepest_wish = 8;          // splits for that
constexpr int deepest_split = 24;        // splits for D > 0
constexpr double slow_poles = 100;       // times lowest_omega: what varies there

void check_coverage(const CertifiedLoop& loop, double nyquist, Discrepancies& list) {
  if (loop.intervals.empty()) {
    report(list, "intervals", "there are none");
    return;
  }
  double edge = nyquist;
  for (std::size_t i = 0; i < loop.intervals.size() && list.size() < enough; ++i) {
    const auto& interval = loop.intervals[i];
    const double top = interval.omega + interval.reach;
    if (!(interval.reach > 0) || !(interval.omega > interval.reach)) {
      report(list, fmt::format("intervals/reach/{}", i),
             fmt::format("recorded {:.12g} around {:.12g} rad/s: above zero and below that",
                         interval.reach, interval.omega));
    } else if (!(std::abs(top - edge) <= frequency_agreement * edge)) {
      report(list, fmt::format("intervals/omega/{}", i),
             fmt::format("ends at {:.12g} rad/s: {:.12g} is next", top, edge));
    }
    edge = interval.omega - interval.reach;
  }
  if (list.empty())
    compare(list, "lowest_omega", loop.lowest_omega, edge, frequency_agreement * edge);
}

// The recorded disk, margin and slope against the disk by brute force.
class IntervalCheck {
 public:
  IntervalCheck(const HeldDevice& device, const Sampling& sampling, const CertifiedLoop& loop)
      : disk_(device, sampling),
        law_(loop.law),
        period_(static_cast<Long>(sampling.period.num()) / sampling.period.den()) {}

  void check(const CertifiedInterval& interval, std::size_t index, CheckedLoop& found,
             Discrepancies& list) const {
    const auto field = [&](const char* name) {
      return fmt::format("intervals/{}/{}", name, index);
    };
    const SampledDiskPoint point = disk_.at(interval.omega);
    const LongComplex law = law_at(interval.omega);
    const double law_off = std::abs(interval.law - narrow(law));
    if (!(law_off <= number_agreement * std::abs(interval.law))) {
      report(list, field("law_real"),
             fmt::format("recorded {:.12g} {:+.12g}j: found {:.12g} {:+.12g}j", interval.law.real(),
                         interval.law.imag(), static_cast<double>(law.real()),
                         static_cast<double>(law.imag())));
    }
    ++found.intervals;
    if (law != LongComplex(0)) check_disk(interval, point, field, found, list);  // else D = Re Z
    const LongComplex c(interval.center.real(), interval.center.imag());
    const Long r = interval.radius;
    const auto claimed = static_cast<double>(
        point.damping * (std::norm(LongComplex(1) + law * c) - std::norm(law) * r * r));
    const auto margin = static_cast<double>(point.margin(law));
    // c and r are written in double precision, and D is a difference of their squares.
    const auto squares =
        static_cast<double>(point.damping * std::norm(law) * point.radius * point.radius);
    const auto terms = static_cast<double>(point.margin_terms(law));
    const double slack =
        number_agreement * std::abs(margin) + record_rounding * terms +
        static_cast<double>(point.damping * std::norm(law) * point.radius * point.error);
    const Long off = std::abs(c - point.center) + std::abs(r - point.radius);
    const Long moves = std::abs(law) * (2 * point.damping + std::abs(law * point.path)) * off;
    // The margin may reserve as much again as the disk does.
    const double above = slack + margin_rounding * squares + small_reserve * std::abs(margin);
    const double below = above + static_cast<double>(moves);
    if (!(interval.margin <= claimed + above && interval.margin >= claimed - below)) {
      report(list, field("margin"),
             fmt::format("recorded {:.12g}: the recorded disk leaves {:.12g}", interval.margin,
                         claimed));
    }
    // A disk that holds the true one leaves less of |1 + H c| - |H r|, but may have more of their
    // sum.
    const Long sum = std::abs(LongComplex(1) + law * point.center) + std::abs(law) * point.radius;
    const double allowed =
        slack + std::abs(margin) * (small_reserve + static_cast<double>(std::abs(law) * off / sum));
    if (law != LongComplex(0) && !(interval.margin <= margin + allowed)) {
      report(list, field("margin"),
             fmt::format("recorded {:.12g}: only {:.12g} is found", interval.margin, margin));
    }
    check_course(interval, allowed, field, list);
  }

  Long margin_at(Long omega) const { return disk_.at(omega).margin(law_at(omega)); }

 private:
  LongComplex law_at(Long omega) const { return compute_law(law_, omega * period_); }

  template <class Field>
  static void check_disk(const CertifiedInterval& interval, const SampledDiskPoint& point,
                         const Field& field, CheckedLoop& found, Discrepancies& list) {
    const auto radius = static_cast<double>(point.radius);
    const auto error = static_cast<double>(point.error);
    const double off = std::abs(interval.center - narrow(point.center));
    if (!(off + radius <= interval.radius * (1 + number_agreement) + error)) {
      report(list, field(off > largest_reserve - 1 ? "center_real" : "radius"),
             fmt::format("recorded disk {:.12g} around {:.12g} {:+.12g}j: does not hold {:.12g} "
                         "around {:.12g} {:+.12g}j",
                         interval.radius, interval.center.real(), interval.center.imag(), radius,
                         static_cast<double>(point.center.real()),
                         static_cast<double>(point.center.imag())));
    }
    // Where the disk is small beside its centre, it is the centre's sum that the reserve is for.
    const double most =
        largest_reserve * radius + center_reserve * static_cast<double>(std::abs(point.center));
    if (!(interval.radius <= most + error)) {
      report(list, field("radius"),
             fmt::format("recorded {:.12g}: more than {} times the {:.12g} found", interval.radius,
                         largest_reserve, radius));
    }
    const double ratio = interval.radius / radius;
    found.tightest = found.tightest == 0 ? ratio : std::min(found.tightest, ratio);
    found.widest = std::max(found.widest, ratio);
  }

  // Slope by central difference; (vc-1) at both ends.
  template <class Field>
  void check_course(const CertifiedInterval& interval, double slack, const Field& field,
                    Discrepancies& list) const {
    const Long step = 0.01L * interval.reach;
    const auto slope = static_cast<double>(
        (margin_at(interval.omega + step) - margin_at(interval.omega - step)) / (2 * step));
    compare(list, field("slope"), interval.slope, slope,
            slope_agreement * std::max(std::abs(slope), interval.margin / interval.reach) +
                slack / interval.reach);
    for (const double t : {-interval.reach, interval.reach}) {
      const auto end = static_cast<double>(margin_at(interval.omega + t));
      const double claimed =
          interval.margin + interval.slope * t - interval.curvature * t * t - slack;
      if (!(end >= claimed)) {
        report(list, field("curvature"),
               fmt::format("recorded {:.12g}, so that D >= {:.12g} at {:.12g} rad/s: found {:.12g}",
                           interval.curvature, claimed, interval.omega + t, end));
      }
    }
  }

  SampledDisk disk_;
  DiscreteStateSpace law_;
  Long period_;
};

// D > 0 between the points, without the record's slopes and curvatures.
class MarginProof {
 public:
  MarginProof(const HeldDevice& device, const Sampling& sampling, const CertifiedLoop& loop)
      : enclosure_(device, sampling, loop.law), target_(wanted * loop.lowest_margin) {}

  /// The lowest bound over the interval; not above zero where no proof was found.
  double prove(double omega, double reach, int depth, CheckedLoop& found) const {
    throw_if_interrupted("certificate");
    const MarginBound bound = enclosure_.over(omega, reach);
    ++found.enclosures;
    if (bound.lowest >= target_ && bound.lowest > 0) return bound.lowest;
    if (bound.lowest > 0 && depth >= deepest_wish) return bound.lowest;
    if (depth >= deepest_split) return bound.lowest;
    // A wide interval in equal shares of the logarithm.
    const double low_end = omega - reach;
    const double high_end = omega + reach;
    const double cut = high_end > 2 * low_end ? std::sqrt(low_end * high_end) : omega;
    const double low = prove((low_end + cut) / 2, (cut - low_end) / 2, depth + 1, found);
    if (!(low > 0)) return low;
    return std::min(low, prove((cut + high_end) / 2, (high_end - cut) / 2, depth + 1, found));
  }

  /// From `top` towards zero: at zero itself where that can be enclosed, else up to two more
  /// decades.
  double prove_below(double top, CheckedLoop& found) const {
    double lowest = std::numeric_limits<double>::infinity();
    double below = 0;
    for (double edge = top; edge > top / slow_poles && lowest > 0; edge /= 2) {
      below = enclosure_.lowest_below(edge).value_or(0);
      ++found.enclosures;
      if (below > 0 && below >= target_) break;
      const double octave = prove(0.75 * edge, 0.25 * edge, 0, found);
      if (!(octave > 0) && edge < top)
        break;  // rounding's share grows as 1/w: the limit is reached
      lowest = std::min(lowest, octave);
    }
    found.to_zero = below > 0;
    return found.to_zero ? std::min(lowest, below) : lowest;
  }

 private:
  MarginEnclosure enclosure_;
  double target_;
};

void check_claims(const CertifiedLoop& loop, Discrepancies& list) {
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < loop.intervals.size(); ++i) {
    const auto& in = loop.intervals[i];
    const double claim = in.margin - (std::abs(in.slope) + in.curvature * in.reach) * in.reach;
    lowest = std::min(lowest, claim);
    if (!(claim > 0) || !(in.curvature >= 0)) {
      report(list, fmt::format("intervals/curvature/{}", i),
             fmt::format("recorded {:.12g}: leaves a margin of {:.6g}, which must be above zero",
                         in.curvature, claim));
      return;
    }
  }
  compare(list, "lowest_margin", loop.lowest_margin, lowest, number_agreement * lowest);
}

// Nothing varies at lowest_omega where the proof does not reach zero itself.
void check_slow_poles(const HeldDevice& device, const CertifiedLoop& loop, double period,
                      Discrepancies& list) {
  double slowest = std::numbers::pi / period;
  const Eigen::VectorXcd device_poles =
      device.system.A.rows() > 0 ? compute_poles(device.system.A) : Eigen::VectorXcd();
  const double fastest = device_poles.size() > 0 ? device_poles.cwiseAbs().maxCoeff() : 0;
  for (const Complex& pole : device_poles) {
    if (std::abs(pole) > number_agreement * fastest) slowest = std::min(slowest, std::abs(pole));
  }
  if (loop.law.states() > 0) {
    for (const Complex& pole : compute_poles(loop.law.A)) {
      const double distance = std::abs(pole - 1.0) / period;
      if (distance > number_agreement / period) slowest = std::min(slowest, distance);
    }
  }
  if (slow_poles * loop.lowest_omega > slowest) {
    report(list, "lowest_omega",
           fmt::format("recorded {:.6g} rad/s: a pole at {:.6g} rad/s is less than {:g} times that",
                       loop.lowest_omega, slowest, slow_poles));
  }
}

}  // namespace

std::vector<Discrepancy> check_device_shape(const HeldDevice& device) {
  Discrepancies list;
  const StateSpace& s = device.system;
  const Eigen::Index n = s.A.rows();
  const Eigen::Index outputs = s.D.rows();
  const bool fits = s.A.cols() == n && s.B.rows() == n && s.B.cols() == 2 && s.C.cols() == n &&
                    s.C.rows() == outputs && s.D.cols() == 2 && (outputs == 1 || outputs == 2);
  if (!fits) report(list, "device", "its matrices do not fit together");
  if (!s.A.allFinite() || !s.B.allFinite() || !s.C.allFinite() || !s.D.allFinite())
    report(list, "device", "a number is not finite");
  if (!(device.port_inertia > 0) || !std::isfinite(device.port_inertia)) {
    report(list, "device/port_inertia",
           fmt::format("recorded {:.12g}: must be above zero", device.port_inertia));
  }
  return list;
}

std::vector<Discrepancy> check_passive_loop(const HeldDevice& device, const Sampling& sampling,
                                            const CertifiedLoop& loop, CheckedLoop& found) {
  found = {};
  Discrepancies list;
  const double period = sampling.period.to_double();
  check_coverage(loop, std::numbers::pi / period, list);
  if (!list.empty()) return list;
  found.spectral_radius = find_loop_pole(device, sampling, loop.law, {}).magnitude;
  compare(list, "uncoupled_spectral_radius", loop.uncoupled_spectral_radius, found.spectral_radius,
          same_pole);
  if (found.spectral_radius > 1 + stable_pole) {
    report(list, "uncoupled_spectral_radius",
           fmt::format("found {:.12g}: the loop diverges with nothing attached",
                       found.spectral_radius));
  }
  check_claims(loop, list);
  const IntervalCheck check(device, sampling, loop);
  for (std::size_t i = 0; i < loop.intervals.size() && list.size() < enough; ++i)
    check.check(loop.intervals[i], i, found, list);
  if (!list.empty()) return list;

  const MarginProof proof(device, sampling, loop);
  found.smallest_margin = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < loop.intervals.size() && list.empty(); ++i) {
    const auto& interval = loop.intervals[i];
    const double lowest = proof.prove(interval.omega, interval.reach, 0, found);
    found.smallest_margin = std::min(found.smallest_margin, lowest);
    if (!(lowest > 0)) {
      report(list, fmt::format("intervals/omega/{}", i),
             fmt::format("D > 0 could not be shown around {:.12g} rad/s (at least {:.6g})",
                         interval.omega, lowest));
    }
  }
  if (!list.empty()) return list;
  const double lowest = proof.prove_below(loop.lowest_omega, found);
  found.smallest_margin = std::min(found.smallest_margin, lowest);
  if (!(lowest > 0)) report(list, "lowest_omega", "D > 0 could not be shown below it");
  if (!found.to_zero) check_slow_poles(device, loop, period, list);
  return list;
}

}  // namespace gyrator
