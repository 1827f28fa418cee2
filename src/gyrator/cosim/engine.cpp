#include "gyrator/cosim/engine.hpp"

#include <cmath>

namespace gyrator {

std::unique_ptr<Engine> make_engine(EngineKind kind, const Plant& plant, const EngineOptions& options) {
  switch (kind) {
    case EngineKind::cvode: return make_cvode_engine(plant, options);
    case EngineKind::odeint: return make_odeint_engine(plant, options);
    case EngineKind::exact: break;
  }
  return make_exact_engine(plant, options);
}

namespace {

Eigen::VectorXd compute_state_scales(const Plant& plant, double energy, const Eigen::Vector2d& u, double interval) {
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
  return scales;
}

}  // namespace

void StateScales::update(const Eigen::VectorXd& xi, const Eigen::Vector2d& u, double interval) {
  const Eigen::Index n = plant_.states();
  z_.resize(n + 2);
  const auto energy_of = [&](const auto& state) {
    z_.head(n) = state;
    z_.tail(2) = u;
    return z_.dot(plant_.energy.stored * z_);
  };
  // Nothing has moved yet: what the inputs and the operator's springs will bring at once counts.
  const double fastest = plant_.A.cwiseAbs().rowwise().sum().maxCoeff();
  const double start = fastest * interval > 1 ? 1 / fastest : interval;
  const Eigen::VectorXd next = xi + start * (plant_.A * xi + plant_.B * u);
  const double energy = energy_ > 0 ? energy_of(xi) : std::max(energy_of(xi), energy_of(next));
  if (energy > energy_ || states_.size() == 0) {
    energy_ = energy;
    const Eigen::VectorXd scales = compute_state_scales(plant_, energy > 0 ? energy : 1, u, interval);
    states_ = states_.size() == 0 || energy == 0 ? scales : Eigen::VectorXd(states_.cwiseMax(scales));
  }
  states_ = states_.cwiseMax(xi.cwiseAbs());
}

}  // namespace gyrator
