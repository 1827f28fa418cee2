#include "gyrator/core/error.hpp"
#include "gyrator/cosim/engine.hpp"
#include "gyrator/mechanics/plant_dynamics.hpp"

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <boost/numeric/odeint.hpp>
#include <fmt/core.h>

namespace gyrator {
namespace {

namespace odeint = boost::numeric::odeint;

// Runge–Kutta–Fehlberg 7(8) with step control: one-step, so it starts afresh at each hold edge at
// full order, and shares nothing with the other two engines but the equations.
class OdeintEngine final : public Engine {
 public:
  OdeintEngine(const Plant& plant, const EngineOptions& options)
      : Engine(plant),
        plant_(plant),
        options_(options),
        n_(static_cast<std::size_t>(plant.states())),
        y_(n_ + 3),
        z_(plant.states() + plant.inputs()),
        sizes_(plant_) {
    if (plant_.nonlinear) dynamics_.emplace(plant_);
  }

  int prepare(double interval) override {
    intervals_.push_back(interval);
    return static_cast<int>(intervals_.size()) - 1;
  }

  void advance(int segment, double time, const Eigen::Vector2d& u, PlantState& state) override {
    advance_once(intervals_[static_cast<std::size_t>(segment)], time, u, state);
  }

  void advance_once(double interval, double time, const Eigen::Vector2d& u,
                    PlantState& state) override {
    if (interval <= 0) return;
    sizes_.update(state.xi, u, interval);
    const Eigen::VectorXd& scales = sizes_.states();
    const double energy_scale = sizes_.energy() > 0 ? sizes_.energy() : 1;
    for (std::size_t i = 0; i < n_; ++i)
      y_[i] = state.xi(static_cast<Eigen::Index>(i)) / scales(static_cast<Eigen::Index>(i));
    for (std::size_t i = 0; i < 3; ++i) y_[n_ + i] = 0;

    const auto rhs = [&](const std::vector<double>& y, std::vector<double>& dydt, double /*t*/) {
      const Eigen::Index n = plant_.states();
      z_.head(n) = Eigen::Map<const Eigen::VectorXd>(y.data(), n).cwiseProduct(scales);
      if (dynamics_) {
        xi_ = z_.head(n);
        z_.tail(plant_.inputs()) = solve_ports(time, u);
        rate_ = dynamics_->rate(xi_);
      } else {
        z_.tail(2) = u;
        rate_.noalias() = plant_.A * z_.head(n) + plant_.B * u;
      }
      Eigen::Map<Eigen::VectorXd>(dydt.data(), n) = rate_.cwiseQuotient(scales);
      const auto& e = plant_.energy;
      dydt[n_] = options_.ledger ? z_.dot(e.operator_work * z_) / energy_scale : 0;
      dydt[n_ + 1] = options_.ledger ? z_.dot(e.source * z_) / energy_scale : 0;
      dydt[n_ + 2] = options_.ledger ? z_.dot(e.dissipated * z_) / energy_scale : 0;
    };
    auto stepper = odeint::make_controlled<odeint::runge_kutta_fehlberg78<std::vector<double>>>(
        options_.relative_tolerance * 1e-3, options_.relative_tolerance);
    double t = 0;
    double h = interval;
    for (long steps = 0; t < interval; ++steps) {
      if (steps >= options_.max_steps) give_up(time + t, "too many steps", steps);
      h = std::min(h, interval - t);
      const double before = t;
      if (stepper.try_step(rhs, y_, t, h) == odeint::success && t == before)
        give_up(time + t, "step underflow", steps);
      if (!(h > interval * 1e-14)) {
        if (interval - t <= interval * 1e-14) break;
        give_up(time + t, "step underflow", steps);
      }
    }
    for (std::size_t i = 0; i < n_; ++i)
      state.xi(static_cast<Eigen::Index>(i)) = y_[i] * scales(static_cast<Eigen::Index>(i));
    state.operator_work += y_[n_] * energy_scale;
    state.source_work += y_[n_ + 1] * energy_scale;
    state.dissipated += y_[n_ + 2] * energy_scale;
  }

 private:
  const Eigen::VectorXd& solve_ports(double time, const Eigen::Vector2d& u) {
    try {
      return dynamics_->solve(xi_, u);
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("t = {:.9g} s: {}", time, error.place()),
                  error.message());
    }
  }

  [[noreturn]] static void give_up(double time, const char* why, long steps) {
    throw Error(
        ErrorCode::numerical, fmt::format("t = {:.9g} s", time),
        fmt::format(
            "the odeint engine gave up after {} steps in one segment: {}; use another engine "
            "(exact for a linear model, cvode for any), or raise --max-steps",
            steps, why));
  }

  const Plant plant_;
  EngineOptions options_;
  std::size_t n_;
  std::vector<double> y_;
  std::vector<double> intervals_;
  Eigen::VectorXd z_, rate_, xi_;
  std::optional<PlantDynamics> dynamics_;
  StateScales sizes_;
};

}  // namespace

std::unique_ptr<Engine> make_odeint_engine(const Plant& plant, const EngineOptions& options) {
  if (plant.nonlinear && plant.nonlinear->contacts) {
    throw Error(ErrorCode::bad_input, "engine",
                "odeint: cannot find when dry friction and stops switch: use exact or cvode");
  }
  return std::make_unique<OdeintEngine>(plant, options);
}

}  // namespace gyrator
