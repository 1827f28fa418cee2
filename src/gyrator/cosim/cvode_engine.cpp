#include "gyrator/circuits/state_space.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/cosim/contact_switch.hpp"
#include "gyrator/cosim/engine.hpp"
#include "gyrator/mechanics/plant_dynamics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>
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
        n_(plant.states()),
        size_(plant.states() + 3),
        z_(plant.states() + plant.inputs()),
        scales_(plant_) {
    forms_[0] = plant.energy.operator_work;
    forms_[1] = plant.energy.source;
    forms_[2] = plant.energy.dissipated;
    if (plant_.nonlinear) {
      dynamics_.emplace(plant_);
      fastest_ = dynamics_->find_fastest_rate();
      bends_ = dynamics_->find_state_sizes();
      if (plant_.nonlinear->contacts) {
        contacts_.emplace(plant_);
        contact_columns_ = plant_.nonlinear->B.middleCols(2, 3);
        for (const Modes& modes : contacts_->touching()) {
          contacts_->enter(modes);
          const Eigen::VectorXcd poles =
              compute_poles(plant_.A + contact_columns_ * contacts_->closed().leftCols(n_));
          fastest_ = std::max(fastest_, poles.cwiseAbs().maxCoeff());
        }
      }
    } else {
      const Eigen::VectorXcd poles = compute_poles(plant.A);
      fastest_ = poles.size() > 0 ? poles.cwiseAbs().maxCoeff() : 0;
    }
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
    z_.segment(n_, 2) = u;
    u_ = u;
    started_ = time;
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
      z_.head(n_) = xi;
      z_.tail(plant_.inputs()) = dynamics_->solve(xi, u);
      contacts_->close(z_);
      const int crossed = find_violated();
      if (crossed < 0) break;
      contacts_->change(crossed, modes, xi);
    }
    inputs_ = z_.tail(plant_.inputs());
    return inputs_;
  }

 private:
  void set_up() {
    const bool stiff = fastest_ * longest_ > stiff_ratio;
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
                    dynamics_ ? "" : "use the exact engine, or "));
  }

  // C callbacks. Nothing is thrown through SUNDIALS: an exception is kept and rethrown after.
  static int right_hand_side(double t, N_Vector y, N_Vector ydot, void* self_pointer) {
    auto& self = *static_cast<CvodeEngine*>(self_pointer);
    try {
      const double* state = N_VGetArrayPointer(y);
      double* rate = N_VGetArrayPointer(ydot);
      const Eigen::Index n = self.n_;
      double* z = self.z_.data();
      for (Eigen::Index i = 0; i < n; ++i) z[i] = state[i];
      if (self.dynamics_) {
        self.evaluate_nonlinear(t, rate);
        return 0;
      }
      const double* a = self.plant_.A.data();
      const double* b = self.plant_.B.data();
      for (Eigen::Index i = 0; i < n; ++i) rate[i] = b[i] * z[n] + b[n + i] * z[n + 1];
      for (Eigen::Index j = 0; j < n; ++j, a += n) {
        for (Eigen::Index i = 0; i < n; ++i) rate[i] += a[i] * z[j];
      }
      for (std::size_t f = 0; f < 3; ++f) {
        double power = 0;
        if (self.options_.ledger) {
          const double* q = self.forms_[f].data();
          for (Eigen::Index j = 0; j < n + 2; ++j, q += n + 2) {
            double sum = 0;
            for (Eigen::Index i = 0; i < n + 2; ++i) sum += q[i] * z[i];
            power += sum * z[j];
          }
        }
        rate[n + static_cast<Eigen::Index>(f)] = power;
      }
      return 0;
    } catch (...) {
      self.failure_ = std::current_exception();
      return 1;  // a shorter step may find a solution
    }
  }

  static int jacobian(double t, N_Vector y, N_Vector /*fy*/, SUNMatrix J, void* self_pointer,
                      N_Vector, N_Vector, N_Vector) {
    auto& self = *static_cast<CvodeEngine*>(self_pointer);
    if (self.dynamics_) {
      try {
        self.fill_nonlinear_jacobian(t, N_VGetArrayPointer(y), J);
        return 0;
      } catch (...) {
        self.failure_ = std::current_exception();
        return -1;
      }
    }
    const Eigen::Index n = self.n_;
    const Eigen::Map<const Eigen::VectorXd> state(N_VGetArrayPointer(y), n);
    self.z_.head(n) = state;
    Eigen::Map<Eigen::MatrixXd> out(SUNDenseMatrix_Data(J), self.size_, self.size_);
    out.setZero();
    out.topLeftCorner(n, n) = self.plant_.A;
    if (self.options_.ledger) {
      for (std::size_t f = 0; f < 3; ++f) {
        out.row(n + static_cast<Eigen::Index>(f)).head(n) =
            2 * (self.forms_[f] * self.z_).head(n).transpose();
      }
    }
    return 0;
  }

  void solve_ports(double t) {
    xi_ = z_.head(n_);
    try {
      z_.tail(plant_.inputs()) = dynamics_->solve(xi_, u_);
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("t = {:.9g} s: {}", started_ + t, error.place()),
                  error.message());
    }
    if (contacts_) contacts_->close(z_);
  }

  void evaluate_nonlinear(double t, double* rate) {
    solve_ports(t);
    Eigen::Map<Eigen::VectorXd> out(rate, size_);
    out.head(n_) = dynamics_->rate(xi_);
    if (contacts_) out.head(n_).noalias() += contact_columns_ * z_.segment<3>(n_ + 2);
    for (std::size_t f = 0; f < 3; ++f) {
      power_.noalias() = forms_[f] * z_;
      out(n_ + static_cast<Eigen::Index>(f)) = options_.ledger ? z_.dot(power_) : 0;
    }
  }

  void fill_nonlinear_jacobian(double t, const double* y, SUNMatrix J) {
    z_.head(n_) = Eigen::Map<const Eigen::VectorXd>(y, n_);
    solve_ports(t);
    Eigen::Map<Eigen::MatrixXd> out(SUNDenseMatrix_Data(J), size_, size_);
    out.setZero();
    out.topLeftCorner(n_, n_) = dynamics_->jacobian(xi_);
    const Eigen::MatrixXd& dw = dynamics_->port_jacobian();
    const Eigen::Index first = n_ + plant_.nonlinear->first_port();
    Eigen::MatrixXd de;  // of the contacts
    if (contacts_) {
      const Eigen::MatrixXd& closed = contacts_->closed();
      de = closed.leftCols(n_) + closed.middleCols(first, dw.rows()) * dw;
      out.topLeftCorner(n_, n_) += contact_columns_ * de;
    }
    for (std::size_t f = 0; options_.ledger && f < 3; ++f) {
      power_.noalias() = 2 * (forms_[f] * z_);
      auto row = out.row(n_ + static_cast<Eigen::Index>(f)).head(n_);
      row = power_.head(n_).transpose() + power_.segment(first, dw.rows()).transpose() * dw;
      if (contacts_) row += power_.segment<3>(n_ + 2).transpose() * de;
    }
  }

  static int guard_values(double t, N_Vector y, double* values, void* self_pointer) {
    auto& self = *static_cast<CvodeEngine*>(self_pointer);
    try {
      self.z_.head(self.n_) = Eigen::Map<const Eigen::VectorXd>(N_VGetArrayPointer(y), self.n_);
      self.solve_ports(t);
      for (int i = 0; i < ContactSwitch::most_guards; ++i) {
        values[i] = i < self.contacts_->guards() ? self.contacts_->value(i, self.z_) +
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

  // With z_ filled in: the guard that does not hold, or -1.
  int find_violated() const {
    for (int i = 0; i < contacts_->guards(); ++i) {
      if (contacts_->value(i, z_) + tolerance_of(i) < 0) return i;
    }
    return -1;
  }

  int find_crossed() const {
    std::array<int, ContactSwitch::most_guards> roots{};
    check(CVodeGetRootInfo(memory_.get(), roots.data()), "CVodeGetRootInfo", started_);
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
      z_.head(n_) = y;
      solve_ports(reached);
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
      if (!stuck || !dynamics_ || attempt == most_attempts) {
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
  Eigen::Index n_, size_;
  std::array<Eigen::MatrixXd, 3> forms_;
  Eigen::VectorXd z_, sizes_, xi_, power_, bends_;
  double widened_ = 1;  ///< factor on the tolerance, for the rest of a segment
  StateScales scales_;
  std::optional<PlantDynamics> dynamics_;  ///< of a nonlinear plant
  std::optional<ContactSwitch> contacts_;  ///< of one with friction or stops
  std::vector<double> shifts_;             ///< of the guards, so that none starts at zero
  Eigen::MatrixXd contact_columns_;        ///< of B
  Eigen::VectorXd inputs_;
  Eigen::Vector2d u_ = Eigen::Vector2d::Zero();
  double started_ = 0;  ///< the segment's start [s]
  double fastest_ = 0;
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
