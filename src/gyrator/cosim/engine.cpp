#include "gyrator/cosim/engine.hpp"

#include "gyrator/circuits/state_space.hpp"

#include <algorithm>
#include <cmath>

namespace gyrator {

EngineKind choose_engine(const Plant& plant) {
  const bool smooth = plant.nonlinear && !plant.nonlinear->is_piecewise_linear();
  return smooth ? EngineKind::cvode : EngineKind::exact;
}

void ContactEvents::count(const ModeGuard& crossed, int from) {
  if (crossed.part == 0) {
    if (crossed.next == 0) ++sticks;
    if (from == 0) ++slips;
  } else if (crossed.part == 1 && from == 0) {
    ++impacts;
  }
}

Engine::Engine(const Plant& plant) {
  if (plant.nonlinear) ports_ = std::make_unique<PlantDynamics>(plant);
}

Engine::~Engine() = default;

const Eigen::VectorXd& Engine::inputs(const Eigen::Vector2d& u, const PlantState& state) {
  if (ports_) return ports_->solve(state.xi, u);
  linear_inputs_ = u;
  return linear_inputs_;
}

std::unique_ptr<Engine> make_engine(EngineKind kind, const Plant& plant,
                                    const EngineOptions& options) {
  switch (kind) {
    case EngineKind::cvode:
      return make_cvode_engine(plant, options);
    case EngineKind::odeint:
      return make_odeint_engine(plant, options);
    case EngineKind::exact:
      break;
  }
  return make_exact_engine(plant, options);
}

namespace {

Eigen::VectorXd compute_state_scales(const Plant& plant, double energy, const Eigen::Vector2d& u,
                                     double interval) {
  const Eigen::Index n = plant.states();
  Eigen::VectorXd scales = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double stored = plant.energy.stored(i, i);
    if (stored > 0) scales(i) = std::sqrt(energy / stored);
  }
  // What stores no energy of the device itself (a position, a signal in the amplifier) is driven by
  // what does and by the inputs, for as long as it remembers.
  const Eigen::VectorXd driven = plant.A.cwiseAbs() * scales + (plant.B * u).cwiseAbs();
  for (Eigen::Index i = 0; i < n; ++i) {
    const double forgets = std::abs(plant.A(i, i));
    if (!(scales(i) > 0)) scales(i) = driven(i) * (forgets * interval > 1 ? 1 / forgets : interval);
  }
  const double largest = scales.size() > 0 ? scales.maxCoeff() : 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(scales(i) > 0)) scales(i) = largest > 0 ? largest : 1;
  }
  if (plant.nonlinear) {
    for (const auto& thermal : plant.nonlinear->thermal) scales(thermal.state) = 1;  // [K]
  }
  return scales;
}

}  // namespace

double StateScales::energy_of(const Eigen::VectorXd& xi, const Eigen::Vector2d& u) {
  const Eigen::Index n = plant_.states();
  z_.setZero(n + plant_.inputs());
  z_.head(n) = xi;
  z_.segment(n, 2) = u;
  if (plant_.nonlinear) z_.tail(1)(0) = 1;
  return z_.dot(plant_.energy.stored * z_);
}

void StateScales::update(const Eigen::VectorXd& xi, const Eigen::Vector2d& u, double interval) {
  double energy = energy_of(xi, u);
  if (energy_ == 0) {  // nothing has moved yet: what this segment will bring counts
    const HeldStep step = discretize_held(plant_.A, plant_.B, interval);
    energy = std::max(energy, energy_of(step.phi * xi + step.gamma * u, u));
  }
  if (energy > energy_ || states_.size() == 0) {
    energy_ = energy;
    const Eigen::VectorXd scales =
        compute_state_scales(plant_, energy > 0 ? energy : 1, u, interval);
    states_ =
        states_.size() == 0 || energy == 0 ? scales : Eigen::VectorXd(states_.cwiseMax(scales));
  }
  states_ = states_.cwiseMax(xi.cwiseAbs());
}

}  // namespace gyrator
