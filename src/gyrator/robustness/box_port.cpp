#include "gyrator/robustness/box_port.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <limits>
#include <memory>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;
constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

// Unknowns together with what is imposed, (x, v, u), to first order, and what each term has across.
struct BoxPortModel::Solution {
  const Solver* at = nullptr;
  VectorXcd value;               // with port and command
  std::vector<BoxModel> gammas;  // of (box-6), without value
  std::vector<BoxModel> across;  // v_t^T (x, v, u)
};

// (box-7) at one band.
class BoxPortModel::Solver {
 public:
  Solver(const BoxPortModel& model, const Band& band, bool only_width = false)
      : d_(model.d_), variables_(model.variables()), s_(0, band.omega) {
    const Index n = d_.inner();
    const auto terms = static_cast<Index>(d_.terms.size());
    pencil_ = s_ * d_.E - d_.A;
    inverse_ = pencil_.topLeftCorner(n, n).partialPivLu().inverse();
    singular_ = n > 0 && !(inverse_.allFinite() && inverse_.cwiseAbs().maxCoeff() < 1e18);
    regular_ = !singular_;
    if (singular_) return;
    MatrixXd U(n, terms), V(n, terms);
    const BoxModel s = band.s();
    for (Index t = 0; t < terms; ++t) {
      const auto& term = d_.terms[static_cast<std::size_t>(t)];
      U.col(t) = term.row.head(n);
      V.col(t) = term.column.head(n);
      BoxModel theta = model.coefficient(static_cast<std::size_t>(t));
      theta = term.storage ? s * theta : Complex(-1) * theta;
      theta.value = 0;
      sizes_.push_back(theta.spread() + theta.remainder);
      thetas_.push_back(std::move(theta));
    }
    by_term_ = inverse_ * U;
    W_ = V.transpose() * by_term_;
    MatrixXd left = -W_.cwiseAbs();
    for (Index t = 0; t < terms; ++t) left.row(t) *= sizes_[static_cast<std::size_t>(t)];
    if (only_width) {
      P_ = -left;
      return;
    }
    left.diagonal().array() += 1;
    left_.compute(left);
    const VectorXd w = left_.solve(VectorXd::Ones(terms));
    regular_ = w.allFinite() && (terms == 0 || w.minCoeff() > 0);
  }

  bool singular() const { return singular_; }

  // A few steps of the power iteration: P is positive, and no one needs more than two digits.
  double width() const {
    VectorXd w = VectorXd::Ones(P_.rows());
    double growth = 0;
    for (int i = 0; i < 30; ++i) {
      w = P_ * w;
      growth = w.size() > 0 ? w.maxCoeff() : 0;
      if (!(growth > 0) || !std::isfinite(growth)) return growth;
      w = (w / growth).cwiseMax(1e-12);
    }
    return growth;
  }

  /// With the command or the port's velocity as 1.
  Solution drive(bool by_command) const {
    const Index n = d_.inner();
    const Index imposed = by_command ? n + 1 : n;
    VectorXcd all = VectorXcd::Zero(n + 2);
    if (!singular_) all.head(n) = -(inverse_ * pencil_.col(imposed).head(n));
    all(imposed) = 1;
    return complete(all, std::vector<BoxModel>(d_.terms.size()));
  }

  /// With -sum_t load_t u_t on the right, and nothing imposed.
  Solution answer(const std::vector<BoxModel>& load) const {
    const Index n = d_.inner();
    VectorXcd all = VectorXcd::Zero(n + 2);
    for (std::size_t t = 0; t < load.size() && !singular_; ++t)
      all.head(n) -= load[t].value * by_term_.col(static_cast<Index>(t));
    return complete(all, load);
  }

  /// c^T (x, v, u)
  BoxModel form(const Eigen::RowVectorXcd& c, const Solution& x) const {
    BoxModel sum = constant_box((c * x.value)(0));
    sum.variables = variables_;
    if (!regular_) {
      sum.remainder = infinity;
      return sum;
    }
    const Eigen::RowVectorXcd weights = c.head(d_.inner()) * by_term_;
    for (std::size_t t = 0; t < x.gammas.size(); ++t) {
      const Complex weight = weights(static_cast<Index>(t));
      if (weight == 0.0) continue;
      for (std::size_t i = 0; i < variables_; ++i)
        sum.slopes[i] -= plain_product(weight, x.gammas[t].slopes[i]);
      sum.remainder += plain_abs(weight) * x.gammas[t].remainder;
    }
    return sum;
  }

 private:
  Solution complete(const VectorXcd& all, const std::vector<BoxModel>& betas) const {
    const auto terms = static_cast<Index>(d_.terms.size());
    Solution x{this, all, std::vector<BoxModel>(d_.terms.size()), {}};
    if (!regular_) {
      for (std::size_t t = 0; t < d_.terms.size(); ++t) {
        x.gammas[t].remainder = infinity;
        x.across.push_back(x.gammas[t]);
      }
      return x;
    }
    VectorXcd across = VectorXcd::Zero(terms);
    MatrixXcd gammas(terms, static_cast<Index>(variables_));
    VectorXd rest(terms);
    for (Index t = 0; t < terms; ++t) {
      const auto k = static_cast<std::size_t>(t);
      across(t) = (d_.terms[k].column.transpose() * all)(0);
      for (std::size_t i = 0; i < variables_; ++i) {
        gammas(t, static_cast<Index>(i)) = betas[k].slopes[i] + thetas_[k].slopes[i] * across(t);
      }
      rest(t) = betas[k].remainder + thetas_[k].remainder * std::abs(across(t));
    }
    const MatrixXcd moved = -W_ * gammas;
    for (Index t = 0; t < terms; ++t)
      rest(t) += sizes_[static_cast<std::size_t>(t)] * moved.row(t).cwiseAbs().sum();
    const VectorXd rho = left_.solve(rest).unaryExpr(&as_remainder);
    const VectorXd wider = (W_.cwiseAbs() * rho).unaryExpr(&as_remainder);
    for (Index t = 0; t < terms; ++t) {
      const auto k = static_cast<std::size_t>(t);
      BoxModel& gamma = x.gammas[k];
      gamma.variables = variables_;
      gamma.remainder = rho(t);
      BoxModel over = constant_box(across(t));
      over.variables = variables_;
      over.remainder = wider(t);
      for (std::size_t i = 0; i < variables_; ++i) {
        gamma.slopes[i] = gammas(t, static_cast<Index>(i));
        over.slopes[i] = moved(t, static_cast<Index>(i));
      }
      x.across.push_back(over);
    }
    return x;
  }

  const BoxDescriptor& d_;
  std::size_t variables_;
  Complex s_;
  MatrixXcd pencil_, inverse_, by_term_, W_;
  std::vector<BoxModel> thetas_;
  std::vector<double> sizes_;  // bounds of |theta|
  MatrixXd P_;
  Eigen::PartialPivLU<MatrixXd> left_;
  bool singular_ = false;  // at the centre already
  bool regular_ = false;
};

BoxPortModel::BoxPortModel(BoxDescriptor descriptor) : d_(std::move(descriptor)) {
  const Solver rest(*this, {0, 0});
  if (rest.singular()) {
    throw Error(ErrorCode::bad_input, "damping",
                "the device has no steady state with its port held (a held_impedance, or a circuit "
                "that integrates): no guarantee over a box of parts");
  }
  const Solution u = rest.drive(true);
  const Solution v = rest.drive(false);
  command_load_ = store(u);
  motion_load_ = store(v);
  const Solution u1 = rest.answer(command_load_);
  const Solution v1 = rest.answer(motion_load_);
  command_next_load_ = store(u1);
  motion_next_load_ = store(v1);
  effort_c0_ = Complex(-1) * rest_effort(u);
  effort_c1_ = storage_effort(u) - rest_effort(u1);
  sensor_c0_ = sense(v);
  sensor_c1_ = sense(v1);
  blocked_c0_ = sense(u);
  blocked_c1_ = sense(u1);
}

// e_t or a_t of (box-3).
BoxModel BoxPortModel::coefficient(std::size_t term) const {
  const auto& t = d_.terms[term];
  BoxModel model = constant_box(t.value);
  model.variables = variables();
  for (std::size_t i = 0; i < d_.parts; ++i) model.slopes[i + 1] = t.slopes[i];
  model.remainder = t.remainder;
  return model;
}

// E x, as what stands before each u_t.
std::vector<BoxModel> BoxPortModel::store(const Solution& x) const {
  std::vector<BoxModel> load;
  for (std::size_t t = 0; t < d_.terms.size(); ++t) {
    load.push_back(d_.terms[t].storage ? coefficient(t) * x.across[t] : constant_box(0));
  }
  return load;
}

// The port's row of E, and of [A B], times x.
BoxModel BoxPortModel::storage_effort(const Solution& x) const {
  BoxModel sum = constant_box(0);
  for (std::size_t t = 0; t < d_.terms.size(); ++t) {
    const double share = d_.terms[t].row(d_.inner());
    if (d_.terms[t].storage && share != 0)
      sum = sum + Complex(share) * (coefficient(t) * x.across[t]);
  }
  return sum;
}

BoxModel BoxPortModel::rest_effort(const Solution& x) const {
  BoxModel sum = x.at->form(d_.A.row(d_.inner()).cast<Complex>(), x);
  for (std::size_t t = 0; t < d_.terms.size(); ++t) {
    const double share = d_.terms[t].row(d_.inner());
    if (!d_.terms[t].storage && share != 0)
      sum = sum + Complex(share) * (coefficient(t) * x.across[t]);
  }
  return sum;
}

BoxModel BoxPortModel::sense(const Solution& x) const {
  return x.at->form(d_.sensed.cast<Complex>(), x);
}

double BoxPortModel::find_width(const Band& band) const {
  return Solver(*this, band, true).width();
}

BoxPort BoxPortModel::expand(const Band& band) const {
  const Solver at(*this, band);
  const Solution u = at.drive(true);
  const Solution v = at.drive(false);
  const BoxModel s = band.s();
  BoxPort port;
  port.damping = real_part(s * storage_effort(v) - rest_effort(v));
  const BoxModel actuation = rest_effort(u) - s * storage_effort(u);
  if (d_.collocated) {
    port.path = actuation;
    port.blocked = constant_box(0);
    return port;
  }
  port.path = actuation * sense(v);
  port.blocked = sense(u);
  return port;
}

DividedPort BoxPortModel::expand_divided(const Band& band) const {
  const Solver at(*this, band);
  const Solution u = at.drive(true);
  const Solution v = at.drive(false);
  const Solution u1 = at.answer(command_load_);
  const BoxModel s = band.s();
  const BoxModel none = constant_box(0);
  DividedPort port;
  port.damping = real_part(s * storage_effort(v) - rest_effort(v));
  // f_h = s E x - [A B] x, and the actuation is its negative.
  DividedModel actuation{rest_effort(u) - s * storage_effort(u), Complex(-1) * effort_c0_,
                         Complex(-1) * effort_c1_, rest_effort(u1) - storage_effort(u), none};
  if (d_.collocated) {  // nothing needs the second difference
    port.path = actuation;
    port.blocked = {none, none, none, none, none};
    return port;
  }
  const Solution v1 = at.answer(motion_load_);
  const Solution u2 = at.answer(command_next_load_);
  const Solution v2 = at.answer(motion_next_load_);
  actuation.q2 = rest_effort(u2) - storage_effort(u1);
  port.path = actuation * DividedModel{sense(v), sensor_c0_, sensor_c1_, sense(v1), sense(v2)};
  port.blocked = {sense(u), blocked_c0_, blocked_c1_, sense(u1), sense(u2)};
  return port;
}

}  // namespace gyrator
