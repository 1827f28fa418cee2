#include "gyrator/circuits/state_space.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/cosim/engine.hpp"
#include "gyrator/cosim/first_negative.hpp"
#include "gyrator/cosim/step_ladder.hpp"
#include "gyrator/mechanics/plant_modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int most_changes = 200;            // of mode at what is one instant,
constexpr double one_instant = 1e-9;         // this part of a segment
constexpr std::size_t most_own_ladders = 4;  // segment lengths with steps of their own
constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
constexpr double most_rounding = 1e6;  // of two modes' coefficients against each other's
// How far guards may be looked at from a step's ends only: the fastest oscillation turns this far,
// the fastest pole decays this far from where something switched or jumped.
constexpr double farthest_turn = 1.5, farthest_decay = 4;

// The exact engine of a plant that is affine in every mode of its friction, stops and piecewise
// linear elements. In a mode it moves by the steps of a ladder as long as no guard can have been
// crossed, and where one is, by a Taylor series up to the crossing.
class HybridEngine final : public Engine {
 public:
  HybridEngine(const Plant& plant, const EngineOptions& options)
      : Engine(plant),
        plant_(plant),
        options_(options),
        modes_(plant_, true),
        n_(plant.states()),
        size_(plant.states() + 3),
        z_(size_),
        next_(size_),
        scratch_(n_),
        scratch_modes_(modes_.size()),
        u_(plant.inputs()) {
    if (!plant_.nonlinear->ports.empty()) ports_ = std::make_unique<PlantDynamics>(plant_);
  }

  int prepare(double interval) override {
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      if (intervals_[i] == interval) return static_cast<int>(i);
    }
    intervals_.push_back(interval);
    return static_cast<int>(intervals_.size()) - 1;
  }

  void advance(int segment, double time, const Eigen::Vector2d& u, PlantState& state) override {
    const auto at = static_cast<std::size_t>(segment);
    const double interval = intervals_[at];
    if (interval > 0) run(interval, at < most_own_ladders ? at : find_longest(), time, u, state);
  }

  void advance_once(double interval, double time, const Eigen::Vector2d& u,
                    PlantState& state) override {
    if (!(interval > 0)) return;
    if (intervals_.empty()) prepare(interval);
    run(interval, find_longest(), time, u, state);
  }

  const VectorXd& inputs(const Eigen::Vector2d& u, const PlantState& state) override {
    scratch_ = state.xi;
    scratch_modes_ = state.modes;
    if (scratch_modes_.empty()) scratch_modes_ = modes_.start(scratch_);
    load(scratch_, u);
    changed_ = false;
    Mode* mode = &find_mode(scratch_modes_);
    mode = settle_ports(*mode, scratch_, u, scratch_modes_);
    for (int changes = 0; changes < most_changes; ++changes) {
      look(*mode, z_.data(), mode->before);
      const int crossed = find_violated(*mode);
      if (crossed < 0) break;
      mode = &change(*mode, crossed, scratch_modes_, scratch_);
      load(scratch_, u);
    }
    u_.noalias() = mode->inputs * z_;
    return u_;
  }

 private:
  // A guard's values and rates at one point.
  struct Look {
    VectorXd value, rate;
  };
  struct Mode {
    Modes key;
    MatrixXd rate;    // dξ/dt = rate z
    MatrixXd inputs;  // U = inputs z
    std::vector<ModeGuard> guards;
    RowMajor rows, rates, sizes;  // of the guards on z; |rows| + |rates| times the time scale
    Look before, after;
    VectorXd tolerance, polynomial;
    std::vector<MatrixXd> forms;
    double fastest_pole = 0, fastest_turn = 0;
    struct Steps {
      std::unique_ptr<StepLadder> ladder;
      int first = 0;    // step to begin with after a change
      int longest = 0;  // longest step that is ever taken
    };
    std::vector<Steps> ladders;
  };

  std::size_t find_longest() const {
    const std::size_t own = std::min(intervals_.size(), most_own_ladders);
    return static_cast<std::size_t>(
        std::max_element(intervals_.begin(), intervals_.begin() + static_cast<long>(own)) -
        intervals_.begin());
  }

  void load(const VectorXd& xi, const Eigen::Vector2d& u) {
    z_.head(n_) = xi;
    z_(n_) = u(0);
    z_(n_ + 1) = u(1);
    z_(n_ + 2) = 1;
  }

  Mode& find_mode(const Modes& key) {
    if (latest_ && latest_->key == key) return *latest_;
    for (const auto& mode : known_) {
      if (mode->key == key) return *(latest_ = mode.get());
    }
    known_.push_back(make_mode(key));
    return *(latest_ = known_.back().get());
  }

  std::unique_ptr<Mode> make_mode(const Modes& key) const {
    const NonlinearPart& nl = *plant_.nonlinear;
    auto mode = std::make_unique<Mode>();
    mode->key = key;
    const Index m = plant_.inputs();
    // [ξ; U] = full z
    const MatrixXd closed = modes_.close(key);
    MatrixXd full = MatrixXd::Zero(n_ + m, size_);
    full.topLeftCorner(n_, n_).setIdentity();
    full.bottomLeftCorner(m, n_) = closed.leftCols(n_);
    full.block(n_, n_, m, 2) = closed.middleCols(n_, 2);
    full.bottomRightCorner(m, 1) = closed.rightCols(1);
    mode->inputs = full.bottomRows(m);
    mode->rate = nl.B * mode->inputs;
    mode->rate.leftCols(n_) += nl.A;
    if (modes_.sticks(key)) modes_.hold_shaft(mode->rate);
    const EnergyForms& e = plant_.energy;
    if (options_.ledger) {
      for (const MatrixXd* form : {&e.operator_work, &e.source, &e.dissipated})
        mode->forms.emplace_back(full.transpose() * *form * full);
    }
    add_guards(*mode, full);
    const Eigen::VectorXcd poles = compute_poles(mode->rate.leftCols(n_));
    if (poles.size() > 0 && poles.allFinite()) {
      mode->fastest_pole = poles.cwiseAbs().maxCoeff();
      mode->fastest_turn = poles.imag().cwiseAbs().maxCoeff();
    }
    mode->ladders.resize(most_own_ladders);
    return mode;
  }

  void add_guards(Mode& mode, const MatrixXd& full) const {
    mode.guards = modes_.guards(mode.key);
    const auto count = static_cast<Index>(mode.guards.size());
    mode.rows.resize(count, size_);
    for (Index i = 0; i < count; ++i)
      mode.rows.row(i) = mode.guards[static_cast<std::size_t>(i)].row * full;
    mode.rates = mode.rows.leftCols(n_) * mode.rate;
    for (VectorXd* v : {&mode.before.value, &mode.before.rate, &mode.after.value, &mode.after.rate,
                        &mode.tolerance})
      *v = VectorXd::Zero(count);
  }

  Mode::Steps& steps_of(Mode& mode, std::size_t interval) const {
    Mode::Steps& steps = mode.ladders[interval];
    if (!steps.ladder) {
      steps.ladder = std::make_unique<StepLadder>(mode.rate, mode.forms, intervals_[interval]);
      const StepLadder& ladder = *steps.ladder;
      const auto shortest = [&](double rate, double most) {
        int step = 0;
        while (step + 1 < ladder.steps() && rate * ladder.length(step) > most) ++step;
        return step;
      };
      steps.longest = shortest(mode.fastest_turn, farthest_turn);
      steps.first = std::max(steps.longest, shortest(mode.fastest_pole, farthest_decay));
      const double scale = std::min(intervals_[interval], 1 / std::max(1e-300, ladder.rate()));
      mode.sizes = rounding * (mode.rows.cwiseAbs() + scale * mode.rates.cwiseAbs());
      mode.polynomial = VectorXd::Zero(ladder.series().cols());
    }
    return steps;
  }

  void look(const Mode& mode, const double* z, Look& at) const {
    const Index count = mode.rows.rows();
    const double* row = mode.rows.data();
    const double* rate = mode.rates.data();
    for (Index i = 0; i < count; ++i, row += size_, rate += size_) {
      double value = 0;
      double slope = 0;
      for (Index j = 0; j < size_; ++j) {
        value += row[j] * z[j];
        slope += rate[j] * z[j];
      }
      at.value(i) = value;
      at.rate(i) = slope;
    }
  }

  // After look() at z_: the guard that does not hold by more than rounding, or -1.
  int find_violated(Mode& mode) const {
    int found = -1;
    const bool sized = mode.sizes.rows() == mode.rows.rows();
    for (Index i = 0; i < mode.rows.rows(); ++i) {
      double size = 0;
      for (Index j = 0; j < size_; ++j)
        size += (sized ? mode.sizes(i, j) : rounding * std::abs(mode.rows(i, j))) * std::abs(z_(j));
      mode.tolerance(i) = size;
      if (comes_from(mode, i)) mode.tolerance(i) = size = std::max(size, -2 * mode.before.value(i));
      if (found < 0 && mode.before.value(i) + size < 0) found = static_cast<int>(i);
    }
    return found;
  }

  // Where a mode has just begun, the guard of the one before lies at zero but for the rounding of
  // two sets of coefficients. As long as it rises, the motion agrees with the change.
  bool comes_from(const Mode& mode, Index guard) const {
    const ModeGuard& of = mode.guards[static_cast<std::size_t>(guard)];
    return changed_ && of.part == changed_part_ && of.next == changed_from_ &&
           mode.before.rate(guard) > 0 &&
           -mode.before.value(guard) < most_rounding * mode.tolerance(guard);
  }

  // Ports whose bends the present mode oversteps, after a jump of u, are solved all at once.
  Mode* settle_ports(Mode& mode, VectorXd& xi, const Eigen::Vector2d& u, Modes& modes) {
    if (!ports_) return &mode;
    look(mode, z_.data(), mode.before);
    (void)find_violated(mode);
    bool holds = true;
    for (std::size_t i = 0; i < mode.guards.size(); ++i) {
      const auto at = static_cast<Index>(i);
      if (mode.guards[i].part >= modes_.first_port() &&
          mode.before.value(at) + mode.tolerance(at) < 0)
        holds = false;
    }
    if (holds) return &mode;
    ports_->solve(xi, u);
    for (std::size_t k = 0; k + modes_.first_port() < modes.size(); ++k)
      modes[modes_.first_port() + k] =
          modes_.mode_of_port(k, ports_->arguments()(static_cast<Index>(k)));
    return &find_mode(modes);
  }

  Mode& change(const Mode& mode, int guard, Modes& modes, VectorXd& xi) {
    const ModeGuard& crossed = mode.guards[static_cast<std::size_t>(guard)];
    changed_ = true;
    changed_part_ = crossed.part;
    changed_from_ = modes[crossed.part];
    modes[crossed.part] = crossed.next;
    if (modes_.comes_to_rest(crossed)) modes_.hold_shaft(xi);
    return find_mode(modes);
  }

  void run(double interval, std::size_t ladder, double time, const Eigen::Vector2d& u,
           PlantState& state) {
    if (state.modes.empty()) state.modes = modes_.start(state.xi);
    load(state.xi, u);
    work_ = {};
    changed_ = false;
    Mode* mode = &find_mode(state.modes);
    mode = settle_ports(*mode, state.xi, u, state.modes);
    double left = interval;
    double left_then = left;
    for (int changes = 0;;) {
      const int crossed = follow(*mode, steps_of(*mode, ladder), left);
      state.xi = z_.head(n_);
      if (crossed < 0) break;
      if (left_then - left > one_instant * interval) {
        left_then = left;
        changes = 0;
      }
      if (++changes > most_changes) give_up(*mode, crossed, time + interval - left);
      const ModeGuard& guard = mode->guards[static_cast<std::size_t>(crossed)];
      state.events.count(guard, mode->key[guard.part]);
      mode = &change(*mode, crossed, state.modes, state.xi);
      z_.head(n_) = state.xi;
    }
    state.operator_work += work_[0];
    state.source_work += work_[1];
    state.dissipated += work_[2];
  }

  [[noreturn]] void give_up(const Mode& mode, int guard, double time) const {
    throw Error(ErrorCode::numerical,
                modes_.name(mode.guards[static_cast<std::size_t>(guard)].part),
                fmt::format("switches more than {} times at t = {:.9g} s: the circuit and its "
                            "contacts agree on no mode there",
                            most_changes, time));
  }

  // Moves z_ on until a guard is crossed, which is returned, or `left` is over.
  int follow(Mode& mode, Mode::Steps& steps, double& left) {
    StepLadder& ladder = *steps.ladder;
    look(mode, z_.data(), mode.before);
    if (const int violated = find_violated(mode); violated >= 0) return violated;
    int step = steps.first;
    while (left > 0) {
      int next = step;
      while (next < ladder.steps() && ladder.length(next) > left) ++next;
      if (next < ladder.steps() && try_step(mode, ladder, next)) {
        left -= ladder.length(next);
        step = std::max(next - 1, steps.longest);
        continue;
      }
      if (next + 1 < ladder.steps()) {
        step = next + 1;
        continue;
      }
      const int last = ladder.steps() - 1;
      const double piece = std::min(left, ladder.length(last));
      const int crossed = follow_series(mode, ladder, piece, left);
      if (crossed >= 0) return crossed;
      look(mode, z_.data(), mode.before);
      step = std::max(last - 1, steps.longest);
    }
    return -1;
  }

  // Takes a step if no guard can have been crossed in it.
  bool try_step(Mode& mode, const StepLadder& ladder, int step) {
    ladder.move(step, z_.data(), next_.data());
    next_.tail<3>() = z_.tail<3>();
    look(mode, next_.data(), mode.after);
    const double h = ladder.length(step);
    const Look& a = mode.before;
    const Look& b = mode.after;
    for (Index i = 0; i < mode.rows.rows(); ++i) {
      const double tolerance = mode.tolerance(i);
      if (b.value(i) + tolerance < 0) return false;
      if (!(a.rate(i) < 0 && b.rate(i) > 0)) continue;
      // Below the point where its tangents meet no guard of one bend comes.
      const double s =
          std::clamp((b.value(i) - a.value(i) - b.rate(i) * h) / (a.rate(i) - b.rate(i)), 0.0, h);
      if (a.value(i) + a.rate(i) * s + tolerance < 0) return false;
    }
    ladder.book(step, z_.data(), work_);
    z_.swap(next_);
    std::swap(mode.before, mode.after);
    return true;
  }

  int follow_series(Mode& mode, StepLadder& ladder, double piece, double& left) {
    ladder.expand(z_.data(), piece);
    double first = 2;
    int crossed = -1;
    for (Index i = 0; i < mode.rows.rows(); ++i) {
      mode.polynomial.noalias() = ladder.series().transpose() * mode.rows.row(i).transpose();
      mode.polynomial(0) += mode.tolerance(i);
      const double part = find_first_negative(mode.polynomial);
      if (part < first) {
        first = part;
        crossed = static_cast<int>(i);
      }
    }
    const double part = std::min(first, 1.0);
    ladder.book_to(part, work_);
    ladder.move_to(part, z_.data());
    left = crossed < 0 && piece == left ? 0 : left - part * piece;
    return crossed;
  }

  const Plant plant_;
  EngineOptions options_;
  PlantModes modes_;
  Index n_, size_;
  VectorXd z_, next_, scratch_;
  Modes scratch_modes_;
  VectorXd u_;
  StepLadder::Work work_{};
  bool changed_ = false;  // and the last change of mode
  std::size_t changed_part_ = 0;
  signed char changed_from_ = 0;
  std::vector<double> intervals_;
  std::vector<std::unique_ptr<Mode>> known_;
  Mode* latest_ = nullptr;  // of these, the one asked for last
  std::unique_ptr<PlantDynamics> ports_;
};

}  // namespace

std::unique_ptr<Engine> make_hybrid_engine(const Plant& plant, const EngineOptions& options) {
  return std::make_unique<HybridEngine>(plant, options);
}

}  // namespace gyrator
