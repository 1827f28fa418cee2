#include "gyrator/cosim/ledger_equations.hpp"

#include "gyrator/circuits/state_space.hpp"
#include "gyrator/core/error.hpp"

#include <algorithm>

#include <fmt/core.h>

namespace gyrator {

LedgerEquations::LedgerEquations(const Plant& plant, bool ledger)
    : plant_(plant),
      ledger_(ledger),
      n_(plant.states()),
      size_(plant.states() + 3),
      z_(plant.states() + plant.inputs()) {
  forms_[0] = plant.energy.operator_work;
  forms_[1] = plant.energy.source;
  forms_[2] = plant.energy.dissipated;
  if (plant_.nonlinear) {
    dynamics_.emplace(plant_);
    fastest_ = dynamics_->find_fastest_rate();
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
}

void LedgerEquations::begin(const Eigen::Vector2d& u, double time) {
  z_.segment(n_, 2) = u;
  u_ = u;
  started_ = time;
}

void LedgerEquations::compute_rate(double t, const double* y, double* rate) {
  double* z = z_.data();
  for (Eigen::Index i = 0; i < n_; ++i) z[i] = y[i];
  if (dynamics_) {
    compute_nonlinear_rate(t, rate);
  } else {
    compute_linear_rate(rate);
  }
}

void LedgerEquations::compute_jacobian(double t, const double* y, double* out) {
  z_.head(n_) = Eigen::Map<const Eigen::VectorXd>(y, n_);
  if (dynamics_) {
    compute_nonlinear_jacobian(t, out);
  } else {
    compute_linear_jacobian(out);
  }
}

void LedgerEquations::close(double t, const double* y) {
  z_.head(n_) = Eigen::Map<const Eigen::VectorXd>(y, n_);
  solve_ports(t);
}

void LedgerEquations::close(const Eigen::VectorXd& xi, const Eigen::Vector2d& u) {
  z_.head(n_) = xi;
  z_.tail(plant_.inputs()) = dynamics_->solve(xi, u);
  if (contacts_) contacts_->close(z_);
}

void LedgerEquations::solve_ports(double t) {
  xi_ = z_.head(n_);
  try {
    z_.tail(plant_.inputs()) = dynamics_->solve(xi_, u_);
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("t = {:.9g} s: {}", started_ + t, error.place()),
                error.message());
  }
  if (contacts_) contacts_->close(z_);
}

void LedgerEquations::compute_linear_rate(double* rate) const {
  const Eigen::Index n = n_;
  const double* z = z_.data();
  const double* a = plant_.A.data();
  const double* b = plant_.B.data();
  for (Eigen::Index i = 0; i < n; ++i) rate[i] = b[i] * z[n] + b[n + i] * z[n + 1];
  for (Eigen::Index j = 0; j < n; ++j, a += n) {
    for (Eigen::Index i = 0; i < n; ++i) rate[i] += a[i] * z[j];
  }
  for (std::size_t f = 0; f < 3; ++f) {
    double power = 0;
    if (ledger_) {
      const double* q = forms_[f].data();
      for (Eigen::Index j = 0; j < n + 2; ++j, q += n + 2) {
        double sum = 0;
        for (Eigen::Index i = 0; i < n + 2; ++i) sum += q[i] * z[i];
        power += sum * z[j];
      }
    }
    rate[n + static_cast<Eigen::Index>(f)] = power;
  }
}

void LedgerEquations::compute_nonlinear_rate(double t, double* rate) {
  solve_ports(t);
  Eigen::Map<Eigen::VectorXd> out(rate, size_);
  out.head(n_) = dynamics_->rate(xi_);
  if (contacts_) out.head(n_).noalias() += contact_columns_ * z_.segment<3>(n_ + 2);
  for (std::size_t f = 0; f < 3; ++f) {
    power_.noalias() = forms_[f] * z_;
    out(n_ + static_cast<Eigen::Index>(f)) = ledger_ ? z_.dot(power_) : 0;
  }
}

void LedgerEquations::compute_linear_jacobian(double* out) const {
  Eigen::Map<Eigen::MatrixXd> J(out, size_, size_);
  J.setZero();
  J.topLeftCorner(n_, n_) = plant_.A;
  for (std::size_t f = 0; ledger_ && f < 3; ++f) {
    J.row(n_ + static_cast<Eigen::Index>(f)).head(n_) = 2 * (forms_[f] * z_).head(n_).transpose();
  }
}

void LedgerEquations::compute_nonlinear_jacobian(double t, double* out) {
  solve_ports(t);
  Eigen::Map<Eigen::MatrixXd> J(out, size_, size_);
  J.setZero();
  J.topLeftCorner(n_, n_) = dynamics_->jacobian(xi_);
  const Eigen::MatrixXd& dw = dynamics_->port_jacobian();
  const Eigen::Index first = n_ + plant_.nonlinear->first_port();
  Eigen::MatrixXd de;  // of the contacts
  if (contacts_) {
    const Eigen::MatrixXd& closed = contacts_->closed();
    de = closed.leftCols(n_) + closed.middleCols(first, dw.rows()) * dw;
    J.topLeftCorner(n_, n_) += contact_columns_ * de;
  }
  for (std::size_t f = 0; ledger_ && f < 3; ++f) {
    power_.noalias() = 2 * (forms_[f] * z_);
    auto row = J.row(n_ + static_cast<Eigen::Index>(f)).head(n_);
    row = power_.head(n_).transpose() + power_.segment(first, dw.rows()).transpose() * dw;
    if (contacts_) row += power_.segment<3>(n_ + 2).transpose() * de;
  }
}

}  // namespace gyrator
