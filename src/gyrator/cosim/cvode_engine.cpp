#include "gyrator/core/error.hpp"
#include "gyrator/cosim/contact_switch.hpp"
#include "gyrator/cosim/engine.hpp"
#include "gyrator/cosim/ledger_equations.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <memory>
#include <utility>
#include <vector>

#include <cvode/cvode.h>
#include <fmt/core.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.hpp>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

namespace gyrator {
namespace {

// A segment is stiff when its fastest mode has died out many times over before it ends. Then
// BDF with Newton; otherwise Adams with fixed-point iteration, whose cost is the accuracy's.
constexpr double stiff_ratio = 40;

// An argument of a nonlinear law is followed to this many tolerances of the size at which it bends,
// by no less than this part of a state's own tolerance (rounding is near).
constexpr double looser_than_bend = 1e4;
constexpr double sharpest_part = 1e-4;

// Where a guard lies below zero by more than this part of the tolerance, what it guards is over.
constexpr double below_tolerance = 1e-3;
constexpr int most_changes = 200;     // of mode at what is one instant,
constexpr double one_instant = 1e-9;  // this part of a segment

struct CvodeFree {
  void operator()(void* memory) const { CVodeFree(&memory); }
};
struct VectorFree {
  void operator()(N_Vector v) const { N_VDestroy(v); }
};
struct MatrixFree {
  void operator()(SUNMatrix m) const { SUNMatDestroy(m); }
};
struct LinearSolverFree {
  void operator()(SUNLinearSolver s) const { SUNLinSolFree(s); }
};
struct NonlinearSolverFree {
  void operator()(SUNNonlinearSolver s) const { SUNNonlinSolFree(s); }
};
using CvodeMemory = std::unique_ptr<void, CvodeFree>;
using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, VectorFree>;
using Matrix = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, MatrixFree>;
using LinearSolver = std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, LinearSolverFree>;
using NonlinearSolver =
    std::unique_ptr<std::remove_pointer_t<SUNNonlinearSolver>, NonlinearSolverFree>;

// SUNDIALS CVODE over y = [ξ; operator work; source work; heat]: the energies are integrated with
// the motion and under the same error control. Restarted at every edge of the hold, never
// stepping over one.
class CvodeEngine final : public Engine {
 public:
  CvodeEngine(const Plant& plant, const EngineOptions& options)
      : Engine(plant),
        plant_(plant),
        options_(options),
        equations_(plant_, options.ledger),
        contacts_(equations_.contacts()),
        n_(plant.states()),
        size_(equations_.size()),
        scales_(plant_) {
    if (equations_.dynamics()) bends_ = equations_.dynamics()->find_state_sizes();
    sizes_ = Eigen::VectorXd::Ones(size_);
    y_.reset(N_VNew_Serial(size_, context_));
  }

  int prepare(double interval) override {
    intervals_.push_back(interval);
    longest_ = std::max(longest_, interval);
    return static_cast<int>(intervals_.size()) - 1;
  }

  void advance(int segment, double time, const Eigen::Vector2d& u, PlantState& state) override {
    advance_once(intervals_[static_cast<std::size_t>(segment)], time, u, state);
  }

  void advance_once(double interval, double time, const Eigen::Vector2d& u,
                    PlantState& state) override {
    if (interval <= 0) return;
    longest_ = std::max(longest_, interval);
    if (!memory_) set_up();
    set_sizes(state, u);
    equations_.begin(u, time);
    double* y = N_VGetArrayPointer(y_.get());
    for (Eigen::Index i = 0; i < n_; ++i) y[i] = state.xi(i);
    for (Eigen::Index i = n_; i < size_; ++i) y[i] = 0;
    double reached = 0;
    if (contacts_) {
      follow_contacts(interval, time, state);
    } else {
      integrate(reached, interval, time);
    }
    for (Eigen::Index i = 0; i < n_; ++i) state.xi(i) = y[i];
    state.operator_work += y[n_];
    state.source_work += y[n_ + 1];
    state.dissipated += y[n_ + 2];
  }

  const Eigen::VectorXd& inputs(const Eigen::Vector2d& u, const PlantState& state) override {
    if (!contacts_) return Engine::inputs(u, state);
    Modes modes = state.modes.empty() ? contacts_->start(state.xi) : state.modes;
    Eigen::VectorXd xi = state.xi;
    if (scales_.states().size() == 0) set_sizes(state, u);
    for (int changes = 0; changes < most_changes; ++changes) {
      contacts_->enter(modes);
      equations_.close(xi, u);
      const int crossed = find_violated();
      if (crossed < 0) break;
      contacts_->change(crossed, modes, xi);
    }
    inputs_ = equations_.z().tail(plant_.inputs());
    return inputs_;
  }

 private:
  void set_up() {
    const bool stiff = equations_.fastest_rate() * longest_ > stiff_ratio;
    shifts_.assign(ContactSwitch::most_guards, 0);
    memory_.reset(CVodeCreate(stiff ? CV_BDF : CV_ADAMS, context_));
    check(CVodeInit(memory_.get(), right_hand_side, 0.0, y_.get()), "CVodeInit", 0);
    check(CVodeSetUserData(memory_.get(), this), "CVodeSetUserData", 0);
    check(CVodeWFtolerances(memory_.get(), error_weights), "CVodeWFtolerances", 0);
    check(CVodeSetMaxNumSteps(memory_.get(), options_.max_steps), "CVodeSetMaxNumSteps", 0);
    check(CVodeSetErrHandlerFn(memory_.get(), keep_message, this), "CVodeSetErrHandlerFn", 0);
    if (contacts_) {
      std::array<int, ContactSwitch::most_guards> falling;
      falling.fill(-1);
      check(CVodeRootInit(memory_.get(), ContactSwitch::most_guards, guard_values), "CVodeRootInit",
            0);
      check(CVodeSetRootDirection(memory_.get(), falling.data()), "CVodeSetRootDirection", 0);
      check(CVodeSetNoInactiveRootWarn(memory_.get()), "CVodeSetNoInactiveRootWarn", 0);
    }
    if (stiff) {
      matrix_.reset(SUNDenseMatrix(size_, size_, context_));
      linear_solver_.reset(SUNLinSol_Dense(y_.get(), matrix_.get(), context_));
      check(CVodeSetLinearSolver(memory_.get(), linear_solver_.get(), matrix_.get()),
            "CVodeSetLinearSolver", 0);
      check(CVodeSetJacFn(memory_.get(), jacobian), "CVodeSetJacFn", 0);
    } else {
      nonlinear_solver_.reset(SUNNonlinSol_FixedPoint(y_.get(), 0, context_));
      check(CVodeSetNonlinearSolver(memory_.get(), nonlinear_solver_.get()),
            "CVodeSetNonlinearSolver", 0);
    }
  }

  // The error is measured against the largest size each quantity has had so far, not against its
  // momentary value: a current that passes through zero is not followed to nothing.
  void set_sizes(const PlantState& state, const Eigen::Vector2d& u) {
    scales_.update(state.xi, u, longest_);
    const double energy = scales_.energy() > 0 ? scales_.energy() : 1;
    for (Eigen::Index i = 0; i < size_; ++i) {
      sizes_(i) = i < n_ ? scales_.states()(i) : energy;
    }
    // Where the rails leave an inductor's current hardly any choice, a small error of it is a large
    // one of the voltage, and of the energies.
    for (Eigen::Index i = 0; i < bends_.size(); ++i) {
      sizes_(i) = std::clamp(looser_than_bend * bends_(i), sharpest_part * sizes_(i), sizes_(i));
    }
  }

  void check(int flag, const char* function, double time) const {
    if (flag >= 0) return;
    throw Error(
        ErrorCode::numerical, fmt::format("t = {:.9g} s", time),
        fmt::format("the cvode engine gave up ({} returned {}{}{}); {}raise --max-steps or the "
                    "tolerance",
                    function, CVodeGetReturnFlagName(flag), message_.empty() ? "" : ": ", message_,
                    equations_.dynamics() ? "" : "use the exact engine, or "));
  }

  // C callbacks. Nothing is thrown through SUNDIALS: an exception is kept and rethrown after.
  static int right_hand_side(double t, N_Vector y, N_Vector ydot, void* self_pointer) {
    auto& self = *static_cast<CvodeEngine*>(self_pointer);
    try {
      self.equations_.compute_rate(t, N_VGetArrayPointer(y), N_VGetArrayPointer(ydot));
      return 0;
    } catch (...) {
      self.failure_ = std::current_exception();
      return 1;  // a shorter step may find a solution
    }
  }

  static int jacobian(double t, N_Vector y, N_Vector /*fy*/, SUNMatrix J, void* self_pointer,
                      N_Vector, N_Vector, N_Vector) {
    auto& self = *static_cast<CvodeEngine*>(self_pointer);
    try {
      self.equations_.compute_jacobian(t, N_VGetArrayPointer(y), SUNDenseMatrix_Data(J));
      return 0;
    } catch (...) {
      self.failure_ = std::current_exception();
      return -1;
    }
  }

  static int guard_values(double t, N_Vector y, double* values, void* self_pointer) {
    auto& self = *static_cast<CvodeEngine*>(self_pointer);
    try {
      self.equations_.close(t, N_VGetArrayPointer(y));
      for (int i = 0; i < ContactSwitch::most_guards; ++i) {
        values[i] = i < self.contacts_->guards() ? self.contacts_->value(i, self.equations_.z()) +
                                                       self.shifts_[static_cast<std::size_t>(i)]
                                                 : 1;
      }
      return 0;
    } catch (...) {
      self.failure_ = std::current_exception();
      return -1;
    }
  }

  double tolerance_of(int guard) const {
    return below_tolerance * options_.relative_tolerance * contacts_->size(guard, sizes_);
  }

  // With [ξ; U] closed: the guard that does not hold, or -1.
  int find_violated() const {
    for (int i = 0; i < contacts_->guards(); ++i) {
      if (contacts_->value(i, equations_.z()) + tolerance_of(i) < 0) return i;
    }
    return -1;
  }

  int find_crossed() const {
    std::array<int, ContactSwitch::most_guards> roots{};
    check(CVodeGetRootInfo(memory_.get(), roots.data()), "CVodeGetRootInfo", equations_.started());
    const auto it = std::find_if(roots.begin(), roots.end(), [](int root) { return root < 0; });
    return it == roots.end() ? -1 : static_cast<int>(it - roots.begin());
  }

  // Mode by mode to the end of the segment.
  void follow_contacts(double interval, double time, PlantState& state) {
    if (state.modes.empty()) state.modes = contacts_->start(state.xi);
    contacts_->enter(state.modes);
    Eigen::Map<Eigen::VectorXd> y(N_VGetArrayPointer(y_.get()), n_);
    double reached = 0;
    double then = 0;
    for (int changes = 0;;) {
      equations_.close(reached, y.data());
      int crossed = find_violated();
      for (int i = 0; i < contacts_->guards(); ++i)
        shifts_[static_cast<std::size_t>(i)] = tolerance_of(i);
      if (crossed < 0) {
        if (!(interval - reached > 1e-13 * interval)) break;
        if (!integrate(reached, interval, time)) break;
        crossed = find_crossed();
        if (crossed < 0) continue;
      }
      if (reached - then > one_instant * interval) {
        then = reached;
        changes = 0;
      }
      if (++changes > most_changes) {
        throw Error(ErrorCode::numerical, contacts_->name_of(crossed),
                    fmt::format("switches more than {} times at t = {:.9g} s: the device and its "
                                "contacts agree on no mode there",
                                most_changes, time + reached));
      }
      contacts_->count(crossed, state.events);
      contacts_->change(crossed, state.modes, y);
    }
    contacts_->hold(y);
  }

  // To the end of the segment, or to where a guard falls below zero (true). At the bend of a law
  // beside an inductance the step may shrink to nothing; from where it stopped the rest of the
  // segment is taken with a wider tolerance. What that costs shows in the energy ledger, which
  // every run is held to.
  bool integrate(double& reached, double interval, double time) {
    constexpr int most_attempts = 4;
    constexpr double widening = 30;
    widened_ = 1;
    for (int attempt = 1;; ++attempt) {
      check(CVodeReInit(memory_.get(), reached, y_.get()), "CVodeReInit", time);
      check(CVodeSetStopTime(memory_.get(), interval), "CVodeSetStopTime", time);
      const int flag = CVode(memory_.get(), interval, y_.get(), &reached, CV_NORMAL);
      const auto failure = std::exchange(failure_, nullptr);
      const bool stuck = flag == CV_ERR_FAILURE || flag == CV_CONV_FAILURE ||
                         flag == CV_RHSFUNC_FAIL || flag == CV_REPTD_RHSFUNC_ERR;
      if (!stuck || !equations_.dynamics() || attempt == most_attempts) {
        if (flag < 0 && failure) std::rethrow_exception(failure);
        check(flag, "CVode", time + reached);
        return flag == CV_ROOT_RETURN;
      }
      widened_ *= widening;
    }
  }

  static int error_weights(N_Vector y, N_Vector weights, void* self_pointer) {
    const auto& self = *static_cast<CvodeEngine*>(self_pointer);
    const double* size = N_VGetArrayPointer(y);
    double* w = N_VGetArrayPointer(weights);
    for (Eigen::Index i = 0; i < self.size_; ++i) {
      const double momentary = i < self.bends_.size() ? 0 : std::abs(size[i]);
      w[i] = 1 / (self.options_.relative_tolerance * self.widened_ *
                  std::max(self.sizes_(i), momentary));
    }
    return 0;
  }

  static void keep_message(int code, const char* /*module*/, const char* /*function*/,
                           char* message, void* self) {
    if (code < 0) static_cast<CvodeEngine*>(self)->message_ = message;
  }

  const Plant plant_;
  EngineOptions options_;
  LedgerEquations equations_;
  ContactSwitch* const contacts_;  ///< of the equations; null without friction and stops
  Eigen::Index n_, size_;
  Eigen::VectorXd sizes_, bends_, inputs_;
  double widened_ = 1;  ///< factor on the tolerance, for the rest of a segment
  StateScales scales_;
  std::vector<double> shifts_;  ///< of the guards, so that none starts at zero
  double longest_ = 0;
  std::vector<double> intervals_;
  std::exception_ptr failure_;
  std::string message_;
  sundials::Context context_;
  Vector y_;
  Matrix matrix_;
  LinearSolver linear_solver_;
  NonlinearSolver nonlinear_solver_;
  CvodeMemory memory_;
};

}  // namespace

std::unique_ptr<Engine> make_cvode_engine(const Plant& plant, const EngineOptions& options) {
  return std::make_unique<CvodeEngine>(plant, options);
}

}  // namespace gyrator
