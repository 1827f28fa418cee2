#include "gyrator/robustness/box_proof.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/mechanics/plant.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/disk_proof.hpp"
#include "gyrator/passivity/tail_quadrature.hpp"
#include "gyrator/robustness/box_search.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <numbers>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <fmt/core.h>

namespace gyrator {
namespace {

using std::numbers::pi;

constexpr int fewest_direct = 8;
constexpr int most_direct = 200;
constexpr double pole_reserve = 2;  // by which poles may be faster than the nominal ones

SampledSide make_side(const DiscreteStateSpace& law, const Sampling& sampling) {
  SampledSide side{law, sampling.period.to_double(), sampling.delay.to_double(), law.D};
  if (law.states() == 0) return side;
  const Eigen::Index n = law.states();
  const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(n, n) - law.A;
  const Eigen::VectorXd steady = left.partialPivLu().solve(law.B);
  if (!steady.allFinite() || (left * steady - law.B).norm() > 1e-9 * law.B.norm() ||
      steady.norm() > 1e12 * law.B.norm()) {
    throw Error(ErrorCode::bad_input, "controller",
                "the controller integrates without end: no guarantee over a box of parts");
  }
  side.steady_law += law.C.dot(steady);
  const double size = std::abs(law.D) + law.C.cwiseAbs().dot(steady.cwiseAbs());
  if (std::abs(side.steady_law) < 1e-12 * size) side.steady_law = 0;
  return side;
}

class Prover {
 public:
  Prover(const DeviceMaker& maker, const PartBox& whole, const Sampling& sampling,
         const DiscreteStateSpace& law)
      : maker_(maker),
        sampling_(sampling),
        side_(make_side(law, sampling)),
        descriptors_(maker, whole),
        whole_(whole) {
    PortModel center(maker(whole.center));
    const double w_s = 2 * pi / side_.period;
    const int direct =
        std::clamp(count_resonant_aliases(center.poles(), w_s), fewest_direct, most_direct);
    const double tail_end = pole_reserve * find_tail_end((direct + 0.5) * w_s, center.poles());
    settings_ = {direct, tail_end};
    const BoxPortModel point(descriptors_.make({whole.center, whole.half}));
    if (!has_limit_at_rest(point, side_)) {
      throw Error(ErrorCode::bad_input, "controller",
                  "the sensor sees a steady command with the port held, and the controller answers "
                  "it: no guarantee over a box of parts");
    }
  }

  BoxProof prove(const BoxBudget& budget, const std::function<void(double)>& progress) {
    BoxProof proof;
    if (!is_passive(whole_.center, proof)) return proof;
    proof.margin = std::numeric_limits<double>::infinity();
    const auto start = std::chrono::steady_clock::now();
    std::vector<SearchBox> open{{whole_, make_base_bands(side_.period), 1}};
    double done = 0;
    while (!open.empty()) {
      throw_if_interrupted("tolerance");
      const std::vector<SearchBox> batch = take_batch(open);
      const std::vector<BoxPass> passes = search(batch, budget.threads);
      // From the last: what is pushed last is taken first.
      for (std::size_t i = batch.size(); i-- > 0;) {
        const BoxPass& pass = passes[i];
        ++proof.boxes;
        proof.intervals += pass.intervals;
        proof.margin = std::min(proof.margin, pass.lowest);
        if (pass.open.empty()) {
          done += batch[i].volume;
          if (progress) progress(done);
          continue;
        }
        if (pass.suspect && !is_passive(*pass.suspect, proof)) return proof;
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
        const char* reason = is_finest(batch[i], pass)          ? "too close to the limit there"
                             : proof.boxes >= budget.most_boxes ? "the budget of boxes is used up"
                             : spent.count() > budget.seconds   ? "the time is used up"
                                                                : nullptr;
        if (reason) {
          proof.outcome = BoxOutcome::undecided;
          proof.at = pass.suspect.value_or(batch[i].parts.center);
          proof.omega = pass.omega;
          proof.margin = pass.margin;
          proof.reason = reason;
          return proof;
        }
        push_halves(open, batch[i], pass);
      }
    }
    proof.outcome = BoxOutcome::passive;
    return proof;
  }

 private:
  static constexpr double finest = 1e-6;      // of a part's range
  static constexpr std::size_t together = 8;  // boxes, whatever the number of cores

  static std::vector<SearchBox> take_batch(std::vector<SearchBox>& open) {
    const auto count = static_cast<std::ptrdiff_t>(std::min(together, open.size()));
    std::vector<SearchBox> batch(std::make_move_iterator(open.end() - count),
                                 std::make_move_iterator(open.end()));
    open.erase(open.end() - count, open.end());
    return batch;
  }

  std::vector<BoxPass> search(const std::vector<SearchBox>& batch, int threads) const {
    std::vector<BoxPass> passes(batch.size());
    tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
    arena.execute([&] {
      tbb::parallel_for(std::size_t{0}, batch.size(), [&](std::size_t i) {
        passes[i] = search_box(descriptors_, side_, settings_, batch[i]);
      });
    });
    return passes;
  }

  bool is_finest(const SearchBox& box, const BoxPass& pass) const {
    return box.parts.half[pass.split] < finest * whole_.half[pass.split];
  }

  // The half with the suspect is looked at first.
  static void push_halves(std::vector<SearchBox>& open, const SearchBox& box, const BoxPass& pass) {
    const std::size_t i = pass.split;
    const double center = box.parts.center[i];
    const double suspect = pass.suspect ? (*pass.suspect)[i] : center;
    const double toward = suspect < center ? -1 : 1;
    for (const double side : {-toward, toward}) {
      SearchBox half{box.parts, pass.open, box.volume / 2};
      half.parts.half[i] /= 2;
      half.parts.center[i] += side * half.parts.half[i];
      open.push_back(std::move(half));
    }
  }

  // By the point proof; where not, `proof` says so.
  bool is_passive(const std::vector<double>& values, BoxProof& proof) {
    const Device device = maker_(values);
    const bool nominal = values == whole_.center;
    if (nominal) require_stable_device(device);
    PortModel model(device);
    const DiskProof point = prove_disk(model, sampling_, side_.law);
    // Where the point proof cannot tell, the boxes about it will.
    if (point.outcome != ProofOutcome::violated) return !nominal || is_stable_alone(device, proof);
    proof.outcome = BoxOutcome::not_passive;
    proof.at = values;
    proof.omega = point.omega;
    proof.margin = point.margin;
    return false;
  }

  // The nominal loop with nothing attached.
  bool is_stable_alone(const Device& device, BoxProof& proof) const {
    const Eigen::MatrixXd loop = build_device_loop(device, FreeOperator{}, sampling_, side_.law);
    if (compute_spectral_radius(loop) <= 1 + stability_tolerance) return true;
    const DominantPole pole = find_dominant_pole(loop, side_.period);
    proof.outcome = BoxOutcome::not_passive;
    proof.at = whole_.center;
    proof.omega = 2 * pi * pole.frequency_hz;
    proof.margin = std::numeric_limits<double>::quiet_NaN();
    proof.reason = fmt::format(
        "the loop is unstable with nothing attached (spectral radius {:.6g})", pole.magnitude);
    return false;
  }

  const DeviceMaker& maker_;
  Sampling sampling_;
  SampledSide side_;
  BoxDescriptorMaker descriptors_;
  PartBox whole_;
  SearchSettings settings_;
};

}  // namespace

BoxProof prove_box(const DeviceMaker& maker, const PartBox& whole, const Sampling& sampling,
                   const DiscreteStateSpace& law, const BoxBudget& budget,
                   const std::function<void(double)>& progress) {
  if (whole.center.size() + 1 > BoxModel::most_variables) {
    throw Error(ErrorCode::bad_input, "tolerances",
                std::to_string(whole.center.size()) +
                    " quantities with tolerances: a guarantee has at most " +
                    std::to_string(BoxModel::most_variables - 1));
  }
  return Prover(maker, whole, sampling, law).prove(budget, progress);
}

}  // namespace gyrator
