#include "gyrator/mechanics/plant_modes.hpp"

#include <cmath>
#include <cstdlib>

namespace gyrator {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t friction_part = 0, stop_part = 1;

signed char sign_of(int mode) {
  return mode > 0 ? 1 : -1;
}

// Slopes of a piecewise linear law as its port's w has them, and its bends at +-edge.
struct Lines {
  double inner, outer, edge;
};
Lines lines_of(const NonlinearPort& port) {
  const double rest = port.leak - port.companion;
  return {evaluate_law(port.law, 0).slope + rest,
          evaluate_law(port.law, 2 * port.size).slope + rest, port.size};
}

}  // namespace

PlantModes::PlantModes(const Plant& plant, bool with_ports)
    : nl_(*plant.nonlinear), n_(plant.states()), m_(plant.inputs()), names_(2) {
  if (nl_.contacts) {
    friction_ = nl_.contacts->friction;
    stops_ = nl_.contacts->stops;
    shaft_velocity_ = nl_.contacts->shaft_velocity.state;
    port_position_ = plant.port_position.state;
    port_velocity_ = plant.port_velocity.state;
    push_ = nl_.B.col(NonlinearPart::friction_input);
    if ((shaft_velocity_.array() != 0).count() == 1)
      shaft_velocity_.cwiseAbs().maxCoeff(&shaft_state_);
    const double mobility = shaft_velocity_.dot(push_);
    const double terms = shaft_velocity_.cwiseAbs().dot(push_.cwiseAbs());
    if (!(mobility > 1e-12 * terms)) friction_.reset();
  }
  names_[friction_part] = "mechanics.friction";
  names_[stop_part] = "mechanics.stops";
  if (!with_ports) return;
  ports_ = nl_.ports.size();
  for (const NonlinearPort& port : nl_.ports) names_.push_back(port.element);
}

Modes PlantModes::start(const VectorXd& xi) const {
  Modes modes(size(), 0);
  if (friction_) {
    const double v = shaft_velocity_.dot(xi);
    const bool fast = friction_->breakaway > friction_->sliding &&
                      friction_->stribeck_velocity > 0 &&
                      std::abs(v) > friction_->stribeck_velocity;
    if (v != 0) modes[friction_part] = static_cast<signed char>(std::copysign(fast ? 2 : 1, v));
  }
  if (stops_) {
    const double x = port_position_.dot(xi);
    const double v = port_velocity_.dot(xi);
    const auto side_of = [&](double beyond, double outwards) {
      return stops_->stiffness * beyond + stops_->damping * outwards >= 0 ? 1 : 2;
    };
    if (stops_->upper && x > *stops_->upper)
      modes[stop_part] = static_cast<signed char>(side_of(x - *stops_->upper, v));
    if (stops_->lower && x < *stops_->lower)
      modes[stop_part] = static_cast<signed char>(-side_of(*stops_->lower - x, -v));
  }
  return modes;
}

signed char PlantModes::mode_of_port(std::size_t port, double argument) const {
  const double edge = nl_.ports[port].size;
  if (std::abs(argument) <= edge) return 0;
  return argument > 0 ? 1 : -1;
}

RowVectorXd PlantModes::row(const RowVectorXd& state, Index input, double by) const {
  RowVectorXd row = RowVectorXd::Zero(n_ + m_);
  if (state.size() > 0) row.head(n_) = state;
  if (input >= 0) row(n_ + input) += by;
  return row;
}

// Signed, of the upper (+) or lower stop.
RowVectorXd PlantModes::deflection(int side) const {
  return row(port_position_, m_ - 1, -(side > 0 ? stops_->upper : stops_->lower).value());
}

// One row for each contact's input and each port's, all zero on [ξ; U].
MatrixXd PlantModes::equations(const Modes& modes) const {
  const Index contacts = nl_.contacts ? 3 : 0;
  MatrixXd rows = MatrixXd::Zero(contacts + static_cast<Index>(ports_), n_ + m_);
  const Index one = m_ - 1;
  const RowVectorXd none;
  if (contacts > 0) {
    rows.row(0) = row(none, NonlinearPart::friction_input, 1);
    rows.row(1) = row(none, NonlinearPart::stop_input, 1);
    rows.row(2) = row(none, NonlinearPart::deflection_input, 1);
  }
  if (friction_) {
    const int mode = modes[friction_part];
    const double drop = friction_->breakaway - friction_->sliding;
    if (mode == 0) {
      rows.row(0) << shaft_velocity_ * nl_.A, shaft_velocity_ * nl_.B;
    } else if (std::abs(mode) == 1 && drop > 0 && friction_->stribeck_velocity > 0) {
      rows.row(0).head(n_) = -drop / friction_->stribeck_velocity * shaft_velocity_;
      rows(0, n_ + one) = sign_of(mode) * friction_->breakaway;
    } else {
      rows(0, n_ + one) = sign_of(mode) * friction_->sliding;
    }
  }
  if (stops_ && modes[stop_part] != 0) {
    const int mode = modes[stop_part];
    const RowVectorXd beyond = deflection(mode);
    rows.row(2) -= beyond;
    if (std::abs(mode) == 1) {
      rows.row(1) += stops_->stiffness * beyond;
      rows.row(1).head(n_) += stops_->damping * port_velocity_;
    }
  }
  for (std::size_t k = 0; k < ports_; ++k) {
    const Lines lines = lines_of(nl_.ports[k]);
    const auto at = contacts + static_cast<Index>(k);
    const auto port = static_cast<Index>(k);
    const int mode = modes[first_port() + k];
    const double slope = mode == 0 ? lines.inner : lines.outer;
    rows.row(at) = row(-slope * nl_.C.row(port), nl_.first_port() + port, 1);
    rows.row(at).tail(m_) -= slope * nl_.D.row(port);
    rows(at, n_ + one) -= mode * lines.edge * (lines.inner - lines.outer);
  }
  return rows;
}

MatrixXd PlantModes::close(const Modes& modes) const {
  MatrixXd closed = MatrixXd::Zero(m_, n_ + m_);
  closed.rightCols(m_).setIdentity();
  MatrixXd rows = equations(modes);
  const Index count = rows.rows();
  if (count == 0) return closed;
  for (Index i = 0; i < count; ++i) rows.row(i) /= rows.row(i).segment(n_ + 2, count).norm();
  const MatrixXd unknown = rows.middleCols(n_ + 2, count);
  rows.middleCols(n_ + 2, count).setZero();
  closed.middleCols(n_ + 2, count).setZero();
  closed.middleRows(2, count) = -unknown.partialPivLu().solve(rows);
  return closed;
}

void PlantModes::add_friction_guards(int mode, std::vector<ModeGuard>& guards) const {
  const Index one = m_ - 1;
  const auto add = [&](RowVectorXd guard, double constant, int next) {
    guard(n_ + one) += constant;
    guards.push_back({std::move(guard), friction_part, static_cast<signed char>(next)});
  };
  if (mode == 0) {
    const RowVectorXd held = row({}, NonlinearPart::friction_input, 1);
    add(-held, friction_->breakaway, -1);
    add(held, friction_->breakaway, 1);
    return;
  }
  const int way = sign_of(mode);
  const RowVectorXd speed = row(way * shaft_velocity_, -1, 0);
  const double edge = friction_->breakaway > friction_->sliding ? friction_->stribeck_velocity : 0;
  if (std::abs(mode) == 2) {
    add(speed, -edge, way);
    return;
  }
  add(speed, 0, 0);
  if (edge > 0) add(-speed, edge, 2 * way);
}

void PlantModes::add_stop_guards(int mode, std::vector<ModeGuard>& guards) const {
  const auto add = [&](const RowVectorXd& guard, int next) {
    guards.push_back({guard, stop_part, static_cast<signed char>(next)});
  };
  if (mode == 0) {
    if (stops_->upper) add(-deflection(1), 1);
    if (stops_->lower) add(deflection(-1), -1);
    return;
  }
  const int side = sign_of(mode);
  const RowVectorXd beyond = side * deflection(side);
  RowVectorXd effort = stops_->stiffness * beyond;
  effort.head(n_) += side * stops_->damping * port_velocity_;
  if (std::abs(mode) == 1) {
    add(effort, stops_->damping > 0 ? 2 * side : 0);
  } else {
    add(-effort, side);
    add(beyond, 0);
  }
}

std::vector<ModeGuard> PlantModes::guards(const Modes& modes) const {
  std::vector<ModeGuard> guards;
  if (friction_) add_friction_guards(modes[friction_part], guards);
  if (stops_) add_stop_guards(modes[stop_part], guards);
  for (std::size_t k = 0; k < ports_; ++k) {
    const auto port = static_cast<Index>(k);
    RowVectorXd argument(n_ + m_);
    argument << nl_.C.row(port), nl_.D.row(port);
    const double edge = nl_.ports[k].size;
    const int mode = modes[first_port() + k];
    const auto add = [&](double by, double constant, int next) {
      RowVectorXd guard = by * argument;
      guard(n_ + m_ - 1) += constant;
      guards.push_back({guard, first_port() + k, static_cast<signed char>(next)});
    };
    if (mode == 0) {
      add(-1, edge, 1);
      add(1, edge, -1);
    } else {
      add(mode, -edge, 0);
    }
  }
  return guards;
}

void PlantModes::hold_shaft(Eigen::Ref<MatrixXd> states) const {
  if (!friction_) return;
  const double mobility = shaft_velocity_.dot(push_);
  for (Index j = 0; j < states.cols(); ++j) {
    const double off = shaft_velocity_.dot(states.col(j)) / mobility;
    states.col(j) -= off * push_;
    if (shaft_state_ >= 0) states(shaft_state_, j) = 0;
  }
}

}  // namespace gyrator
