#include "gyrator/controllers/virtual_chain.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

double effort_of(const ChainLink& link, double distance, double rate) {
  const double effort = link.law.stiffness * distance + link.law.damping * rate;
  if (!link.unilateral) return effort;
  return distance > 0 ? std::max(effort, 0.0) : 0.0;
}

}  // namespace

std::string_view name_of(Integration integration) {
  switch (integration) {
    case Integration::explicit_euler:
      return "explicit";
    case Integration::semi_implicit:
      return "semi_implicit";
    case Integration::implicit:
      break;
  }
  return "implicit";
}

void check_chain(const ChainModel& model) {
  const auto refuse = [](const char* what, double value, const char* rule) {
    throw Error(ErrorCode::bad_input, "controller",
                fmt::format("simulated {} {:g}: must be {}", what, value, rule));
  };
  for (std::size_t i = 0; i < model.bodies; ++i) {
    if (!(model.inertia[i] > 0)) refuse("inertia", model.inertia[i], "above 0");
    if (!(model.damping[i] >= 0)) refuse("damping", model.damping[i], "at least 0");
  }
  for (std::size_t i = 0; i <= model.bodies; ++i) {
    const SpringDamper& law = model.links[i].law;
    if (!(law.stiffness >= 0)) refuse("stiffness", law.stiffness, "at least 0");
    if (!(law.damping >= 0)) refuse("damping", law.damping, "at least 0");
  }
  if (model.substeps < 1) refuse("substeps", model.substeps, "at least 1");
}

VirtualChain::VirtualChain(const ChainModel& model, double step)
    : model_(model), h_(step / model.substeps) {
  check_chain(model);
}

double VirtualChain::first_effort(double position, double velocity) const {
  return effort_of(model_.links[0], position - state_.position[0], velocity - state_.velocity[0]);
}

void VirtualChain::push(double effort) {
  const ChainLink link = std::exchange(model_.links[0], ChainLink{});
  push_ = effort;
  advance(0, 0);
  push_ = 0;
  model_.links[0] = link;
}

void VirtualChain::set_last(double inertia, const SpringDamper& to_ground, double rest) {
  model_.inertia[model_.bodies - 1] = inertia;
  model_.links[model_.bodies].law = to_ground;
  model_.rest = rest;
}

double VirtualChain::advance(double position, double velocity) {
  double effort = 0;
  for (int i = 0; i < model_.substeps; ++i) {
    effort = model_.integration == Integration::implicit ? advance_implicit(position, velocity)
                                                         : advance_forward(position, velocity);
  }
  return effort;
}

// Explicit and semi-implicit: every effort from the state before the step.
double VirtualChain::advance_forward(double position, double velocity) {
  const std::size_t n = model_.bodies;
  auto& x = state_.position;
  auto& v = state_.velocity;
  std::array<double, 3> effort{};
  double left = position;
  double left_rate = velocity;
  for (std::size_t i = 0; i <= n; ++i) {
    const double right = i < n ? x[i] : model_.rest;
    const double right_rate = i < n ? v[i] : 0.0;
    effort[i] = effort_of(model_.links[i], left - right, left_rate - right_rate);
    left = right;
    left_rate = right_rate;
  }
  effort[0] += push_;
  for (std::size_t i = 0; i < n; ++i) {
    const double before = v[i];
    v[i] += h_ * (effort[i] - effort[i + 1] - model_.damping[i] * before) / model_.inertia[i];
    x[i] += h_ * (model_.integration == Integration::explicit_euler ? before : v[i]);
  }
  return effort[0];
}

// Implicit: with e_i' = s_i + g_i (v_left' - v_right'), s_i from the positions before the step and
// g_i = k_i h + c_i, the new velocities solve a tridiagonal system of one or two rows.
double VirtualChain::advance_implicit(double position, double velocity) {
  const std::size_t n = model_.bodies;
  const auto& x = state_.position;
  const auto& v = state_.velocity;
  std::array<double, 3> gap{};    // left - right before the step
  std::array<double, 3> given{};  // s_i
  std::array<double, 3> grip{};   // g_i
  std::size_t contact = 3;
  for (std::size_t i = 0; i <= n; ++i) {
    const SpringDamper& law = model_.links[i].law;
    gap[i] = (i == 0 ? position : x[i - 1]) - (i < n ? x[i] : model_.rest);
    given[i] = law.stiffness * gap[i] + (i == 0 ? law.damping * velocity + push_ : 0.0);
    grip[i] = law.stiffness * h_ + law.damping;
    if (model_.links[i].unilateral) contact = i;
  }
  const auto solve = [&](bool touching) {
    auto s = given;
    auto g = grip;
    if (!touching && contact < 3) s[contact] = g[contact] = 0;
    const double a = model_.inertia[0] / h_ + model_.damping[0] + g[0] + g[1];
    const double p = model_.inertia[0] / h_ * v[0] + s[0] - s[1];
    if (n == 1) return std::array<double, 2>{p / a, 0.0};
    const double b = model_.inertia[1] / h_ + model_.damping[1] + g[1] + g[2];
    const double q = model_.inertia[1] / h_ * v[1] + s[1] - s[2];
    const double determinant = a * b - g[1] * g[1];
    return std::array<double, 2>{(p * b + g[1] * q) / determinant,
                                 (a * q + g[1] * p) / determinant};
  };
  // Rate at which a link closes; the device's position is held, its link closes by the body alone.
  const auto closing = [&](std::size_t i, const std::array<double, 2>& rate) {
    return (i == 0 ? 0.0 : rate[i - 1]) - (i < n ? rate[i] : 0.0);
  };
  const auto first_effort = [&](const std::array<double, 2>& rate) {
    return given[0] - grip[0] * rate[0];
  };

  std::array<double, 2> rate = solve(true);
  double effort = first_effort(rate);
  if (contact < 3) {
    const auto open = solve(false);
    const double open_gap = gap[contact] + h_ * closing(contact, open);
    const double shut_gap = gap[contact] + h_ * closing(contact, rate);
    const double push = given[contact] + grip[contact] * closing(contact, rate);
    double share = 1;  // of the contact's effort
    if (open_gap <= 0 || push <= 0) {
      share = 0;
    } else if (shut_gap <= 0) {
      share = open_gap / (open_gap - shut_gap);  // just enough to stop at the surface
    }
    for (std::size_t i = 0; i < n; ++i) rate[i] = open[i] + share * (rate[i] - open[i]);
    effort = contact == 0 ? share * effort : first_effort(rate);
  }
  for (std::size_t i = 0; i < n; ++i) {
    state_.velocity[i] = rate[i];
    state_.position[i] += h_ * rate[i];
  }
  return effort;
}

DiscreteStateSpace make_chain_law(ChainModel model, double step) {
  for (auto& link : model.links) link.unilateral = false;
  model.rest = 0;
  const auto n = static_cast<Eigen::Index>(model.bodies);
  const Eigen::Index states = 2 * n + 1;
  DiscreteStateSpace law{Eigen::MatrixXd::Zero(states, states), Eigen::VectorXd::Zero(states),
                         Eigen::RowVectorXd::Zero(states), 0};
  // The running chain is linear here: its response to each unit vector is a column.
  for (Eigen::Index column = 0; column <= states; ++column) {
    Eigen::VectorXd unit = Eigen::VectorXd::Unit(states + 1, column);
    ChainState start;
    for (Eigen::Index i = 0; i < n; ++i) {
      start.position[static_cast<std::size_t>(i)] = unit(i);
      start.velocity[static_cast<std::size_t>(i)] = unit(n + i);
    }
    const double y = unit(states);
    VirtualChain chain(model, step);
    chain.place(start);
    const double effort = chain.advance(y, (y - unit(2 * n)) / step);
    Eigen::VectorXd next(states);
    for (Eigen::Index i = 0; i < n; ++i) {
      next(i) = chain.state().position[static_cast<std::size_t>(i)];
      next(n + i) = chain.state().velocity[static_cast<std::size_t>(i)];
    }
    next(2 * n) = y;
    if (column < states) {
      law.A.col(column) = next;
      law.C(column) = effort;
    } else {
      law.B = next;
      law.D = effort;
    }
  }
  return law;
}

}  // namespace gyrator
