#include "gyrator/passivity/disk_proof.hpp"

#include "gyrator/core/interrupt.hpp"
#include "gyrator/cosim/hold.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/alias_remainder.hpp"
#include "gyrator/passivity/tail_quadrature.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr double rounding = 1e-11;   // of the sizes of what is summed
constexpr double narrowest = 1e-10;  // interval, of its frequency
// Of the slowest pole, where the limit at zero frequency is reached; the higher ones where
// rounding, which grows towards zero frequency, takes over before.
constexpr double below_slowest[] = {1e-4, 1e-3, 5e-3};
constexpr int fewest_direct = 12;
constexpr int bounded_beyond = 300;
constexpr int most_direct = 20000;
constexpr int most_followed = 64;  // aliases for that reason alone
constexpr int most_evaluations = 400000;

bool is_zero(const DiscreteStateSpace& law) {
  return law.D == 0 && (law.states() == 0 || law.C.isZero(0));
}

// Slowest pole of device and law [rad/s].
double find_slowest_pole(const PortModel& model, const DiscreteStateSpace& law, double period) {
  double slowest = pi / period;
  const double fastest = model.poles().size() > 0 ? model.poles().cwiseAbs().maxCoeff() : 0;
  for (const auto& pole : model.poles()) {
    if (std::abs(pole) > 1e-12 * fastest) slowest = std::min(slowest, std::abs(pole));
  }
  if (law.states() > 0) {
    for (const auto& pole : compute_poles(law.A)) {
      const double rate = std::abs(pole - 1.0) / period;
      if (rate * period > 1e-9) slowest = std::min(slowest, rate);
    }
  }
  return slowest;
}

class Prover {
 public:
  Prover(PortModel& model, const Sampling& sampling, const DiscreteStateSpace& law)
      : model_(model),
        law_(law),
        period_(sampling.period.to_double()),
        delay_(sampling.delay.to_double()),
        whole_(split_delay(sampling).rest == 0),
        sampling_frequency_(2 * pi / period_),
        idle_(is_zero(law)),
        direct_(std::clamp(count_resonant_aliases(model.poles(), sampling_frequency_),
                           fewest_direct, most_direct + 1)),
        slowest_(find_slowest_pole(model, law, period_)),
        lowest_(below_slowest[0] * slowest_) {
    if (!idle_) {
      remainder_.emplace(model, period_, delay_, whole_, direct_, direct_ + bounded_beyond);
      // Damping that varies too fast to be bounded over a whole sampling frequency is followed.
      if (const int last = remainder_->last_undamped(); last > 0 && last <= most_followed) {
        direct_ = last;
        remainder_.emplace(model, period_, delay_, whole_, direct_, direct_ + bounded_beyond);
      }
      find_residue();
    }
  }

  DiskProof prove() {
    DiskProof proof;
    proof.aliases = direct_;
    proof.bounded_aliases = direct_ + bounded_beyond;
    proof.outcome = ProofOutcome::proved;
    if (direct_ > most_direct) {  // a resonance too far out to be summed up to
      proof.outcome = ProofOutcome::undecided;
      proof.omega = most_direct * sampling_frequency_;
      return proof;
    }
    if (!idle_) choose_lowest();
    proof.lowest_omega = lowest_;
    cover(proof, lowest_, pi / period_);
    if (proof.outcome == ProofOutcome::proved && !idle_) check_limit(proof);
    if (proof.outcome == ProofOutcome::proved) check_damping_above(proof);
    if (proof.outcome == ProofOutcome::proved) {
      proof.margin = std::numeric_limits<double>::infinity();
      for (const auto& interval : proof.intervals)
        proof.margin = std::min(proof.margin, interval.lowest());
    }
    return proof;
  }

 private:
  // The aliases' share of centre and radius without the hold's factor, c_a = hold center.
  struct Aliases {
    TaylorModel center, radius;
  };
  struct Bound {
    ProvedInterval interval;
    double size = 0;   // of what D was summed from
    double slack = 0;  // of D, by what is left out of the sums
    TaylorModel damping;
  };

  // H k_0 S A ~ residue/(jw) towards zero frequency.
  void find_residue() {
    const Complex at_one = law_.response(std::polar(1.0, lowest_ * 1e-3 * period_));
    const PortResponse port = model_.at(lowest_ * 1e-3);
    const Complex limit = at_one * port.sensor_path * port.actuation;
    residue_ = std::isfinite(limit.real()) ? limit.real() : 0;
  }

  // e^(-jw t)
  static TaylorModel turn(double omega, double time, double reach) {
    const Complex value = std::polar(1.0, -omega * time);
    return {value, Complex(0, -time) * value, time * time / 2, reach};
  }

  // (hold-1): integral of e^(-jwTu) over u from 0 to 1.
  TaylorModel hold(double omega, double reach) const {
    const double x = omega * period_;
    const Complex value = compute_normalized_hold(omega, period_);
    const Complex slope =
        x < 1e-3 ? Complex(-x / 3, -0.5 + x * x / 8) : (std::polar(1.0, -x) - value) / x;
    return {value, period_ * slope, period_ * period_ / 6, reach};
  }

  // 1/w^2, for w of either sign.
  static TaylorModel inverse_square(double omega, double reach) {
    const double inverse = 1 / omega;
    const double near = 1 - reach * std::abs(inverse);
    const double curvature = near > 0 ? std::abs(inverse) * inverse * inverse / near
                                      : std::numeric_limits<double>::infinity();
    const TaylorModel once{inverse, -inverse * inverse, curvature, reach};
    return once * once;
  }

  void add_alias(Aliases& sums, int n, double omega, double reach) const {
    const double at = omega + n * sampling_frequency_;
    PortTaylor port = expand_port(model_, std::abs(at), reach);
    if (at < 0) {  // everything is conjugate, and |w| falls as w rises
      for (TaylorModel* part : {&port.path, &port.blocked}) {
        part->value = std::conj(part->value);
        part->slope = -std::conj(part->slope);
      }
      port.damping.slope = -port.damping.slope;
    }
    const TaylorModel weight = inverse_square(at, reach);
    const TaylorModel compliance = Complex(0.5) * reciprocal(port.damping);
    const TaylorModel swing = port.path * compliance;
    const Complex phase = whole_ ? Complex(1) : std::polar(1.0, -n * sampling_frequency_ * delay_);
    sums.center = sums.center + phase * (weight * (port.blocked + swing));
    sums.radius = sums.radius + weight * majorant(swing);
  }

  Aliases sum_aliases(double omega, double reach) const {
    Aliases sums{constant_model(0, reach), constant_model(0, reach)};
    if (idle_) return sums;
    for (int n = 1; n <= direct_; ++n) {
      add_alias(sums, n, omega, reach);
      add_alias(sums, -n, omega, reach);
    }
    sums.center = sums.center + remainder_->center(omega, reach);
    sums.radius = sums.radius + remainder_->radius(omega, reach);
    sums.center = Complex(-1) * (turn(omega, delay_, reach) * sums.center);
    return sums;
  }

  // (proof-1) with L = (f - residue)/(jw) + residue/(jw), k_0 M H = N.
  Bound bound(double omega, double reach) const {
    const PortTaylor base = expand_port(model_, omega, reach);
    const TaylorModel law = expand_law(law_, period_, omega, reach);
    const TaylorModel held = hold(omega, reach);
    const TaylorModel command = law * held * turn(omega, delay_, reach);  // H k_0 = command/(jw)
    const Aliases aliases = sum_aliases(omega, reach);

    const TaylorModel one = constant_model(1, reach);
    const TaylorModel s{Complex(0, omega), Complex(0, 1), 0, reach};
    const TaylorModel f = command * base.path;
    const TaylorModel L = over_j_omega(f + Complex(-residue_), omega);
    const TaylorModel N = over_j_omega(command * base.blocked, omega);
    const TaylorModel E = law * held * aliases.center;                      // H c_a/(jw)
    const TaylorModel G = majorant(law) * majorant(held) * aliases.radius;  // |H r_a|/w
    const TaylorModel W = one + N + s * E;
    const TaylorModel wG = Complex(0, -1) * (s * G);
    const TaylorModel lagging = Complex(0, 1) * over_j_omega(imaginary_part(N), omega);

    const TaylorModel damping = base.damping * (real_part(W * conj(W)) - wG * wG);
    const TaylorModel drive = real_part(conj(W) * L);
    const TaylorModel pole = Complex(residue_) * (real_part(lagging) + real_part(E));
    const TaylorModel spread = majorant(f) * G;
    const TaylorModel D = damping + drive - pole - spread;

    Bound b;
    // Re Z comes from the modes with ten digits (ModalResponse); f has a few roundings of its own,
    // which the division by w leaves as they are.
    constexpr double digits = 8 * std::numeric_limits<double>::epsilon() / rounding;
    b.size = 10 * plain_abs(damping.value) + plain_abs(W.value) * plain_abs(L.value) +
             std::abs(residue_) * plain_abs(E.value) + plain_abs(spread.value) +
             plain_abs(W.value) * plain_abs(f.value) * digits / omega;
    // What D changes by with c_a and r_a: |dD/dr_a| = 2 R |H|^2 r_a + |L| |H|, |dD/dc_a| at most
    // 2 R |H| |W| + |L| |H|.
    const double left_out = idle_ ? 0 : remainder_->left_out();
    b.slack = plain_abs(law.value) * plain_abs(held.value) * left_out *
              (2 * plain_abs(f.value) + 2 * plain_abs(base.damping.value) * omega *
                                            (omega * plain_abs(G.value) + plain_abs(W.value)));
    b.damping = base.damping;
    ProvedInterval& interval = b.interval;
    interval.omega = omega;
    interval.reach = reach;
    interval.law = law.value;
    // c = c_a + k_0 (M + S A/(2R)),  r = r_a + |k_0 S A|/(2R)
    const Complex k0 = (held.value * turn(omega, delay_, 0).value) / Complex(0, omega);
    const double R = base.damping.value.real();
    interval.center = Complex(0, omega) * held.value * aliases.center.value +
                      k0 * (base.blocked.value + base.path.value / (2 * R));
    interval.radius = omega * plain_abs(held.value) * aliases.radius.value.real() +
                      plain_abs(k0 * base.path.value) / (2 * R);
    interval.margin = D.value.real();
    interval.slope = D.slope.real();
    interval.curvature = D.curvature;
    return b;
  }

  static bool holds(const Bound& b) {
    return b.interval.lowest() > rounding * b.size && b.damping.lowest_real() > 0;
  }

  // From the top down, each interval as wide as it may be.
  void cover(DiskProof& proof, double from, double to) {
    std::vector<std::pair<double, double>> open{{from, to}};
    while (!open.empty()) {
      throw_if_interrupted("passivity");
      const auto [low, high] = open.back();
      open.pop_back();
      const double omega = (low + high) / 2;
      const double reach = (high - low) / 2;
      const Bound b = bound(omega, reach);
      ++proof.evaluations;
      if (holds(b)) {
        proof.intervals.push_back(b.interval);
        continue;
      }
      // Over an interval magnitudes are overestimated, in its middle too.
      const Bound middle_alone =
          b.interval.margin <= 0 || b.damping.value.real() <= 0 ? bound(omega, 0) : b;
      // Rounding of Re Z comes from the size of Z.
      const double noise = 1e-12 * omega * model_.blocked().inertia;
      const double damping = middle_alone.damping.value.real();
      proof.active = damping <= -noise;
      if (proof.active ||
          middle_alone.interval.margin + middle_alone.slack < -rounding * middle_alone.size) {
        proof.outcome = ProofOutcome::violated;
      } else if (reach < narrowest * omega || proof.evaluations > most_evaluations ||
                 std::isinf(b.interval.radius) || damping <= 0) {
        proof.outcome = ProofOutcome::undecided;
      }
      if (proof.outcome != ProofOutcome::proved) {
        proof.omega = omega;
        proof.margin =
            proof.active ? middle_alone.damping.value.real() : middle_alone.interval.margin;
        return;
      }
      const double middle = high > 3 * low ? std::sqrt(low * high) : omega;
      open.emplace_back(low, middle);
      open.emplace_back(middle, high);
    }
  }

  // D is even in w, and analytic as far as the slowest pole: below `omega` it changes by less than
  // between there and twice that.
  double change_below(double omega) const {
    return std::abs(bound(2 * omega, 0).interval.margin - bound(omega, 0).interval.margin);
  }

  void choose_lowest() {
    double least = std::numeric_limits<double>::infinity();
    for (const double share : below_slowest) {
      const double change = change_below(share * slowest_);
      if (!(change < least)) continue;
      least = change;
      lowest_ = share * slowest_;
    }
  }

  void check_limit(DiskProof& proof) {
    const Bound at_end = bound(lowest_, 0);
    const double change = change_below(lowest_);
    if (at_end.interval.margin - change > rounding * at_end.size) return;
    proof.outcome = ProofOutcome::undecided;
    proof.omega = lowest_;
    proof.margin = at_end.interval.margin - change;
  }

  // Re Z > 0 from Nyquist up, as far as the tail's power law.
  void check_damping_above(DiskProof& proof) {
    std::vector<std::pair<double, double>> open{
        {pi / period_,
         find_tail_end((direct_ + bounded_beyond + 0.5) * sampling_frequency_, model_.poles())}};
    while (!open.empty()) {
      const auto [low, high] = open.back();
      open.pop_back();
      const double omega = (low + high) / 2;
      const double reach = (high - low) / 2;
      const TaylorModel damping = expand_port(model_, omega, reach).damping;
      ++proof.evaluations;
      // Rounding of Re Z comes from the size of Z.
      const double noise = 1e-12 * omega * model_.blocked().inertia;
      if (damping.lowest_real() > -noise) continue;
      if (damping.value.real() <= -noise) {
        proof.outcome = ProofOutcome::violated;
      } else if (reach < narrowest * omega || proof.evaluations > most_evaluations) {
        proof.outcome = ProofOutcome::undecided;
      }
      if (proof.outcome != ProofOutcome::proved) {
        proof.omega = omega;
        proof.margin = damping.value.real();
        proof.active = proof.margin <= 0;
        return;
      }
      const double middle = high > 3 * low ? std::sqrt(low * high) : omega;
      open.emplace_back(low, middle);
      open.emplace_back(middle, high);
    }
  }

  PortModel& model_;
  const DiscreteStateSpace& law_;
  double period_, delay_;
  bool whole_;
  double sampling_frequency_;
  bool idle_;
  int direct_;
  double slowest_, lowest_;
  std::optional<AliasRemainder> remainder_;
  double residue_ = 0;
};

}  // namespace

DiskProof prove_disk(PortModel& model, const Sampling& sampling, const DiscreteStateSpace& law) {
  return Prover(model, sampling, law).prove();
}

}  // namespace gyrator
