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

Eigen::VectorXd compute_state_scales(const Plant& plant, double energy, double interval) {
  const Eigen::Index n = plant.states();
  Eigen::VectorXd scales = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double stored = plant.energy.stored(i, i);
    if (stored > 0) scales(i) = std::sqrt(energy / stored);
  }
  // What stores no energy of the device itself is driven by what does.
  for (Eigen::Index i = 0; i < n; ++i) {
    if (scales(i) > 0) continue;
    scales(i) = interval * plant.A.row(i).cwiseAbs().dot(scales);
  }
  const double largest = scales.size() > 0 ? scales.maxCoeff() : 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(scales(i) > 0)) scales(i) = largest > 0 ? largest : 1;
  }
  return scales;
}

}  // namespace gyrator
