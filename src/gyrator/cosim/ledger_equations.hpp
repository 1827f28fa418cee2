#pragma once

#include "gyrator/cosim/contact_switch.hpp"
#include "gyrator/mechanics/plant_dynamics.hpp"

#include <array>
#include <optional>

#include <Eigen/Dense>

namespace gyrator {

/// Motion and energies of a plant as one ordinary differential equation, for an integrator:
///   y = [ξ; operator work; source work; heat],   dy/dt = [dξ/dt; zᵀ Q z],   z = [ξ; U]
/// with the forms Q of the plant's energies. Ports (nl-1) are solved and contacts closed in every
/// evaluation, in the mode that contacts() is in. Throws as PlantDynamics::solve(), with the time.
class LedgerEquations {
 public:
  /// `plant` must outlive this. Without `ledger` the energies stay as they are.
  LedgerEquations(const Plant& plant, bool ledger);
  LedgerEquations(const LedgerEquations&) = delete;
  LedgerEquations& operator=(const LedgerEquations&) = delete;

  Eigen::Index size() const { return size_; }
  /// Of the fastest mode [1/s], contacts that touch included.
  double fastest_rate() const { return fastest_; }
  /// Null for a linear plant.
  const PlantDynamics* dynamics() const { return dynamics_ ? &*dynamics_ : nullptr; }
  /// Null without friction and stops.
  ContactSwitch* contacts() { return contacts_ ? &*contacts_ : nullptr; }

  /// A segment that starts at `time` [s] under u; the times below are counted from there.
  void begin(const Eigen::Vector2d& u, double time);
  double started() const { return started_; }

  /// dy/dt into `rate`.
  void compute_rate(double t, const double* y, double* rate);
  /// d(dy/dt)/dy into `out`, by columns.
  void compute_jacobian(double t, const double* y, double* out);

  /// Makes z = [ξ; U] of ξ, the first of y: ports and contacts.
  void close(double t, const double* y);
  /// The same under another u than the segment's.
  void close(const Eigen::VectorXd& xi, const Eigen::Vector2d& u);
  const Eigen::VectorXd& z() const { return z_; }

 private:
  void solve_ports(double t);
  void compute_linear_rate(double* rate) const;
  void compute_nonlinear_rate(double t, double* rate);
  void compute_linear_jacobian(double* out) const;
  void compute_nonlinear_jacobian(double t, double* out);

  const Plant& plant_;
  bool ledger_;
  Eigen::Index n_, size_;
  std::array<Eigen::MatrixXd, 3> forms_;
  Eigen::VectorXd z_, xi_, power_;
  std::optional<PlantDynamics> dynamics_;
  std::optional<ContactSwitch> contacts_;
  Eigen::MatrixXd contact_columns_;  ///< of B
  Eigen::Vector2d u_ = Eigen::Vector2d::Zero();
  double started_ = 0;
  double fastest_ = 0;
};

}  // namespace gyrator
