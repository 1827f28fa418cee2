#include "gyrator/controllers/linear_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <boost/math/tools/toms748_solve.hpp>

namespace gyrator {
namespace {

// x(t)/w from rest as a power series, for times so short that (1 - xx)/k would cancel: from
// m x'' = w - c x' - k x follows a_{n+2} = -((n+1) c/m a_{n+1} + k/m a_n)/((n+1)(n+2)).
double short_response(double c, double k, double inertia, double t) {
  double before = 0;                  // a_n t^n
  double term = t * t / inertia / 2;  // a_{n+1} t^{n+1}
  double sum = term;
  for (int n = 1; n < 12; ++n) {
    const double next = -((n + 1) * c * t * term + k * t * t * before) / ((n + 1.0) * (n + 2.0));
    sum += next;
    before = term;
    term = next;
  }
  return sum;
}

constexpr double most_nodes = 4096;
constexpr double short_time = 0.1;  // in units of the motion's own time

}  // namespace

LinearMotion::LinearMotion(double inertia, double damping, double stiffness, double effort)
    : inertia_(inertia),
      damping_(damping),
      stiffness_(stiffness),
      effort_(effort),
      rate_(-damping / (2 * inertia)),
      spread_(rate_ * rate_ - stiffness / inertia),
      frequency_(spread_ < 0 ? std::sqrt(-spread_) : 0) {}

// exp(A t) = e^(mu t) (C 1 + S (A - mu 1)) for A = [0 1; -k/m -c/m].
MotionStep LinearMotion::step(double time) const {
  double cosine = 0;  // e^(mu t) C
  double sine = 0;    // e^(mu t) S
  if (spread_ < 0) {
    const double decay = std::exp(rate_ * time);
    cosine = decay * std::cos(frequency_ * time);
    sine = decay * std::sin(frequency_ * time) / frequency_;
  } else {
    const double r = std::sqrt(spread_);
    const double slow = std::exp((rate_ - r) * time);
    const double grown = std::expm1(2 * r * time);
    cosine = slow * (grown + 2) / 2;
    sine = r > 0 ? slow * grown / (2 * r) : slow * time;
  }
  MotionStep s;
  s.xx = cosine - rate_ * sine;
  s.xv = sine;
  s.vx = -stiffness_ / inertia_ * sine;
  s.vv = cosine + rate_ * sine;
  s.vw = sine / inertia_;
  const double c = damping_ / inertia_;
  const double k = stiffness_ / inertia_;
  if (std::abs(c) * time + k * time * time < short_time)
    s.xw = short_response(c, k, inertia_, time);
  else
    s.xw = stiffness_ > 0 ? (1 - s.xx) / stiffness_ : (time - sine) / damping_;
  return s;
}

template <class Value>
double LinearMotion::find_root(const Value& value, double from, double to) {
  const double low = value(from);
  const double high = value(to);
  if (low == 0 || low * high > 0) return from;
  std::uintmax_t iterations = 60;
  const auto bracket = boost::math::tools::toms748_solve(
      value, from, to, low, high, boost::math::tools::eps_tolerance<double>(52), iterations);
  return (bracket.first + bracket.second) / 2;
}

double LinearMotion::find_turn(const MotionState& start, double from, double to) const {
  return find_root([&](double t) { return after(start, t).velocity; }, from, to);
}

// The position at `to` is on the other side. A start on the surface itself that moves into its own
// side comes back later.
double LinearMotion::find_passage(const MotionState& start, double from, double to,
                                  double side) const {
  if (from == 0 && start.position == 0) {
    if (!(side * start.velocity > 0)) return 0;
    from = find_turn(start, from, to);
  }
  return find_root([&](double t) { return after(start, t).position; }, from, to);
}

std::optional<double> LinearMotion::find_crossing(const MotionState& start, double horizon,
                                                  bool inside) const {
  // Between two nodes an eighth of an oscillation apart there is at most one extremum.
  const double side = inside ? 1 : -1;
  const int nodes = static_cast<int>(
      std::clamp(std::ceil(frequency_ * horizon * 4 / std::numbers::pi), 1.0, most_nodes));
  double from = 0;
  MotionState before = start;
  for (int i = 1; i <= nodes; ++i) {
    const double to = horizon * i / nodes;
    const MotionState now = after(start, to);
    if (side * now.position < 0) return find_passage(start, from, to, side);
    if (side * before.velocity < 0 && side * now.velocity > 0) {
      const double turn = find_turn(start, from, to);
      if (side * after(start, turn).position < 0) return find_passage(start, from, turn, side);
    }
    from = to;
    before = now;
  }
  return std::nullopt;
}

}  // namespace gyrator
