#include "gyrator/passivity/verdict.hpp"

#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/criteria.hpp"
#include "gyrator/passivity/frequency_grid.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/passivity/virtual_damping.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using std::numbers::pi;

class Judge {
 public:
  explicit Judge(const PassivityModel& model)
      : model_(model),
        period_(model.sampling.period.to_double()),
        law_(make_contact_law(model.controller, period_)),
        textbook_law_(make_textbook_law(model.controller, period_)),
        limits_(model.device, model.sampling, model.controller, FreeOperator{}) {}

  Verdict judge(bool search_counterexample) {
    Verdict v;
    const auto& grid = limits_.grid();
    for (const double omega : grid) laws_.push_back(law_at(omega));
    CriterionResult exact = judge_exact(v);
    const Assumptions assumptions =
        test_assumptions(model_.device, model_.sampling, limits_.disk().model());
    v.criteria = judge_textbook(model_, assumptions, limits_);
    v.criteria.insert(v.criteria.begin() + (v.criteria.size() > 1 ? 2 : 1), exact);
    v.passive = exact.holds;
    v.curves = draw_curves();
    explain(v);
    if (!v.passive && v.device_passive) {
      v.extra_damping = find_extra_damping();
      if (search_counterexample) find_operator(v);
    }
    show_disk(v);
    return v;
  }

 private:
  std::complex<double> law_at(double omega) const {
    return law_.response(std::polar(1.0, omega * period_));
  }

  double radius_of(const Device& device, const Operator& held_by) const {
    return compute_loop_radius(device, held_by, model_.sampling, law_);
  }

  CriterionResult judge_exact(Verdict& v) {
    CriterionResult exact;
    exact.name = "exact_disk";
    exact.applies = true;
    const auto& points = limits_.disks();
    std::vector<double> values;
    for (std::size_t i = 0; i < points.size(); ++i)
      values.push_back(points[i].damping_margin(laws_[i]));
    worst_ = find_minimum(limits_.grid(), values, [&](double omega) {
      return limits_.disk().at(omega).damping_margin(law_at(omega));
    });
    proof_ = prove_disk(limits_.disk().model(), model_.sampling, law_);
    meet_proof();
    exact.margin = worst_.value;
    exact.worst_frequency_hz = worst_.omega / (2 * pi);
    v.worst_disk = limits_.disk().at(worst_.omega);

    const auto& least = limits_.disk().least_damping();
    v.least_damping = least.value;
    v.least_damping_frequency_hz = least.omega / (2 * pi);
    v.device_passive = !least.active && !proof_.active;
    if (proof_.active && proof_.margin < v.least_damping) {
      v.least_damping = proof_.margin;
      v.least_damping_frequency_hz = proof_.omega / (2 * pi);
    }
    // The margin of an active device has no number where the disk is all of the plane.
    if (!v.device_passive && !(std::isfinite(exact.margin) && exact.margin <= v.least_damping)) {
      exact.margin = v.least_damping;
      exact.worst_frequency_hz = v.least_damping_frequency_hz;
    }
    const double radius = radius_of(model_.device, FreeOperator{});
    stable_alone_ = radius <= 1 + stability_tolerance;
    // A corner of the law's own may lie below the grid: a held port finds it.
    const bool stable_held = radius_of(model_.device, ClampedOperator{}) <= 1 + stability_tolerance;
    const bool proved = proof_.outcome == ProofOutcome::proved;
    exact.holds = worst_.value > 0 && stable_alone_ && stable_held && v.device_passive && proved;
    if (const auto wall = find_wall_values(model_.controller)) {
      exact.max_stiffness = limits_.find(Criterion::exact_disk, wall->damping).stiffness;
    } else if (const auto* held = find_held_impedance(model_.device)) {
      exact.max_stiffness = limits_.find(Criterion::exact_disk, held->damping).stiffness;
    }
    if (!v.device_passive) {
      exact.reason = fmt::format("the bare device supplies energy at {:.4g} Hz (Re Z = {:.3g})",
                                 v.least_damping_frequency_hz, v.least_damping);
    } else if (!stable_alone_) {
      exact.reason = fmt::format(
          "the loop is unstable with nothing attached (spectral radius {:.6g})", radius);
    } else if (!stable_held && worst_.value > 0) {
      exact.reason = "the loop is unstable with the port held still";
    } else if (std::isinf(v.worst_disk.radius)) {
      exact.reason =
          "the device's damping vanishes at high frequency faster than the command path: no bound "
          "exists; "
          "give the mechanics some viscous damping";
    } else if (worst_.value > 0 && !proved) {
      exact.reason = fmt::format(
          "too close to the limit to be decided: at {:.4g} Hz the margin is within what rounding "
          "and the last aliases may make",
          proof_.omega / (2 * pi));
    } else {
      exact.reason =
          "aliased disk of all passive operators: command path, sensor place and delay included";
    }
    v.loops = {{"in_contact", law_, radius, proof_}};
    return exact;
  }

  // A dip between the points of the grid is met by the proof alone.
  void meet_proof() {
    if (proof_.outcome != ProofOutcome::violated) return;
    if (proof_.active) return;  // the device by itself
    const double margin = limits_.disk().at(proof_.omega).damping_margin(law_at(proof_.omega));
    if (margin < worst_.value) worst_ = {proof_.omega, margin};
  }

  void explain(Verdict& v) const {
    explain_outcome(v);
    if (has_nonlinear_wrapper(model_.controller))
      v.explanation +=
          " Judged without passivity control and contact effects, which are not linear: simulate "
          "shows them.";
  }

  void explain_outcome(Verdict& v) const {
    const CriterionResult* exact = nullptr;
    const CriterionResult* textbook = nullptr;
    for (const auto& criterion : v.criteria) {
      if (criterion.name == "exact_disk") exact = &criterion;
      if (criterion.name == "frequency_dependent") textbook = &criterion;
    }
    if (v.passive) {
      v.explanation = "No passive operator can make the loop unstable";
      const bool linear = build_device_network(model_.device, FreeOperator{}).network.is_linear();
      v.explanation += linear ? "." : " while its motion stays small (the device is not linear).";
      const bool waves = std::holds_alternative<WaveController>(model_.controller.law);
      if (!textbook->holds && waves)
        v.explanation += " Computed from the position, the same wall would fail [8.46].";
      if (!textbook->holds && !waves)
        v.explanation += " The textbook criterion [8.46] denies it: it is too strict here.";
      return;
    }
    v.explanation = "Some passive operator makes the loop unstable.";
    const bool undecided = proof_.outcome == ProofOutcome::undecided && worst_.value > 0;
    if (undecided && v.device_passive && stable_alone_) {
      v.explanation = fmt::format("Not proved passive: {}.", exact->reason);
    } else if (!v.device_passive || !stable_alone_) {
      v.explanation = fmt::format("Not passive: {}.", exact->reason);
    } else if (textbook->holds) {
      v.explanation += textbook->applies
                           ? " The textbook criterion [8.46] would call it passive."
                           : fmt::format(
                                 " The textbook criterion [8.46] would call it passive, but does "
                                 "not apply here: {}.",
                                 textbook->reason);
    }
  }

  DampingCurves draw_curves() {
    DampingCurves curves;
    const auto& points = limits_.disks();
    const double delay = model_.sampling.delay.to_double();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double omega = limits_.grid()[i];
      const double virtual_part =
          compute_virtual_damping(omega, period_,
                                  std::polar(1.0, -omega * delay) *
                                      textbook_law_.response(std::polar(1.0, omega * period_)));
      curves.frequency_hz.push_back(omega / (2 * pi));
      curves.physical.push_back(points[i].damping);
      curves.virtual_damping.push_back(virtual_part);
      curves.total.push_back(points[i].damping + virtual_part);
      curves.exact.push_back(points[i].damping_margin(laws_[i]));
    }
    return curves;
  }

  // Smallest damper at the port that lifts D above zero everywhere: on the grid, then where the
  // minimum lies between its points. With it no passive operator can change the loop's stability,
  // so that of the damper alone decides.
  std::optional<double> find_extra_damping() {
    std::vector<AliasedDisk::Terms> terms;
    for (const double omega : limits_.grid()) terms.push_back(limits_.disk().collect(omega));
    terms.push_back(limits_.disk().collect(worst_.omega));
    const auto margin = [&](const AliasedDisk::Terms& t, double extra) {
      return limits_.disk().evaluate(t, extra).damping_margin(law_at(t.omega));
    };
    std::optional<double> extra;
    for (int round = 0; round < 20; ++round) {
      extra = lift_above_zero([&](double damping) {
        return std::all_of(terms.begin(), terms.end(),
                           [&](const auto& t) { return margin(t, damping) > 0; });
      });
      if (!extra) return std::nullopt;
      std::vector<double> values;
      for (std::size_t i = 0; i < limits_.grid().size(); ++i)
        values.push_back(margin(terms[i], *extra));
      const Minimum left = find_minimum(limits_.grid(), values, [&](double omega) {
        return limits_.disk().at(omega, *extra).damping_margin(law_at(omega));
      });
      if (left.value > 0) break;
      terms.push_back(limits_.disk().collect(left.omega));
    }
    // As much more as the proof wants between the points.
    if (mends(*extra)) return extra;
    for (double more = 1e-6; more < 1e-2; more *= 1.5) {
      if (mends(*extra * (1 + more))) return *extra * (1 + more);
    }
    return std::nullopt;
  }

  // Whether the loop is passive with a damper at the port, by all that judge_exact asks for.
  bool mends(double extra_damping) const {
    if (!(extra_damping > 0)) return false;
    Device damped = model_.device;
    damped.drive.damping.emplace_back(EddyCurrentBrake{extra_damping, true});
    PortModel port(damped);
    if (prove_disk(port, model_.sampling, law_).outcome != ProofOutcome::proved) return false;
    return radius_of(damped, FreeOperator{}) <= 1 + stability_tolerance &&
           radius_of(damped, ClampedOperator{}) <= 1 + stability_tolerance;
  }

  // Bracket by doubling, then bisect.
  template <class Mended>
  std::optional<double> lift_above_zero(const Mended& mended) const {
    double high = std::max(1e-12, std::abs(worst_.value));
    for (int doublings = 0; !mended(high); high *= 2) {
      if (++doublings > 60) return std::nullopt;
    }
    double low = 0;
    while (high - low > 1e-5 * high) {
      const double middle = (low + high) / 2;
      (mended(middle) ? high : low) = middle;
    }
    return high;
  }

  void show_disk(Verdict& v) {
    double omega = worst_.omega;
    if (v.counterexample && v.counterexample->frequency_hz > 0) {
      omega = 2 * pi * v.counterexample->frequency_hz;
    } else {
      double slowest = pi / period_;
      for (const auto& pole : limits_.disk().model().poles()) {
        if (std::abs(pole) > 0) slowest = std::min(slowest, std::abs(pole));
      }
      omega = std::max(omega, slowest);
    }
    v.shown_disk = limits_.disk().at(omega);
    v.shown_law = law_at(omega);
  }

  // Frequencies where the disk is exceeded, thinned to a couple of dozen, the worst one first.
  void find_operator(Verdict& v) {
    std::vector<double> failing{v.worst_disk.omega};
    const auto& points = limits_.disks();
    std::vector<double> all;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points[i].damping_margin(laws_[i]) <= 0) all.push_back(points[i].omega);
    }
    const std::size_t stride = std::max<std::size_t>(1, all.size() / 24);
    for (std::size_t i = 0; i < all.size(); i += stride) failing.push_back(all[i]);
    v.counterexample =
        find_counterexample(model_.device, model_.sampling, law_, limits_.disk(), failing);
  }

  const PassivityModel& model_;
  double period_;
  DiscreteStateSpace law_;
  DiscreteStateSpace textbook_law_;
  StiffnessLimits limits_;
  std::vector<std::complex<double>> laws_;
  Minimum worst_;  // of D over frequency
  bool stable_alone_ = false;
  DiskProof proof_;
};

// Of two that are both needed: none where one of them is not to be had.
std::optional<double> find_larger(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return std::nullopt;
  return std::max(*a, *b);
}

}  // namespace

Verdict judge_passivity(const PassivityModel& model, bool search_counterexample) {
  require_stable_device(model.device);
  Verdict verdict = Judge(model).judge(search_counterexample);
  verdict.judged = keep_in_contact(model.controller);
  // A tool that leaves its wall is still there: free, it must be passive too.
  const auto* coupling = std::get_if<VirtualCoupling>(&model.controller.law);
  if (!coupling || !coupling->wall || !coupling->wall->unilateral) return verdict;
  if (!verdict.passive && !verdict.extra_damping) return verdict;
  PassivityModel free = model;
  std::get<VirtualCoupling>(free.controller.law).wall.reset();
  if (!verdict.passive) {
    // What mends the contact must mend the free tool, too; more of it harms neither.
    const Verdict unloaded = Judge(free).judge(false);
    if (!unloaded.passive)
      verdict.extra_damping = find_larger(verdict.extra_damping, unloaded.extra_damping);
    return verdict;
  }
  Verdict unloaded = Judge(free).judge(search_counterexample);
  unloaded.loops.front().name = "free";
  if (unloaded.passive) {
    verdict.loops.push_back(unloaded.loops.front());
    return verdict;
  }
  unloaded.judged = free.controller;
  unloaded.explanation += " (With the tool away from its wall; in contact it is passive.)";
  return unloaded;
}

}  // namespace gyrator
