#include "gyrator/verification/sampled_loop.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <fmt/core.h>

namespace gyrator {
namespace {

using Long = long double;
using Matrix = Eigen::Matrix<Long, Eigen::Dynamic, Eigen::Dynamic>;
using Index = Eigen::Index;

constexpr std::int64_t longest_delay = 500;  // periods

struct Plant {
  Matrix A;      // of [x; v; e; v_i, e_i …; y]
  Matrix B;      // by u
  Matrix sense;  // y of the states
};

// Where the device or the operator has a spring to ground, y is a sum of other states already, and
// as a state of its own a pole at one that is not the loop's: w [A B] = 0 with w_y not 0.
void drop_doubled_position(Plant& plant) {
  const Index y = plant.A.rows() - 1;
  Matrix rates(y + 1, y + 2);
  rates << plant.A, plant.B;
  const Matrix scale = rates.cwiseAbs().rowwise().maxCoeff().cwiseMax(1e-300L);
  for (Index i = 0; i <= y; ++i) rates.row(i) /= scale(i, 0);
  Eigen::FullPivLU<Matrix> factors(rates.transpose());
  factors.setThreshold(1e-13L);
  if (factors.dimensionOfKernel() == 0) return;
  const Matrix kernel = factors.kernel();
  Index best = 0;
  kernel.row(y).cwiseAbs().maxCoeff(&best);
  Matrix w = kernel.col(best);
  if (std::abs(w(y, 0)) < 1e-9L * w.cwiseAbs().maxCoeff()) return;
  w.array() /= scale.array();
  plant.sense = -w.topRows(y).transpose() / w(y, 0);
  plant.A = plant.A.topLeftCorner(y, y).eval();
  plant.B = plant.B.topRows(y).eval();
}

Plant make_plant(const HeldDevice& device, const MassSpringDamper& held_by) {
  const StateSpace& s = device.system;
  const Index n = s.A.rows();
  const Index v = n;
  const Index e = n + 1;  // only with a spring: its own integral of v would be a pole at one
  const Index hung_from = e + (held_by.stiffness > 0 ? 1 : 0);
  const auto hung = static_cast<Index>(held_by.resonators.size());
  const Index y = hung_from + 2 * hung;
  Plant plant{Matrix::Zero(y + 1, y + 1), Matrix::Zero(y + 1, 1), Matrix::Zero(1, y + 1)};
  plant.sense(0, y) = 1;
  Matrix& A = plant.A;
  A.topLeftCorner(n, n) = s.A.cast<Long>();
  A.col(v).head(n) = s.B.col(1).cast<Long>();
  plant.B.col(0).head(n) = s.B.col(0).cast<Long>();
  const Long inertia = static_cast<Long>(device.port_inertia) + held_by.inertia;
  A.row(v).head(n) = -s.C.row(0).cast<Long>() / inertia;
  A(v, v) = -(static_cast<Long>(s.D(0, 1)) + held_by.damping) / inertia;
  plant.B(v, 0) = -static_cast<Long>(s.D(0, 0)) / inertia;
  if (held_by.stiffness > 0) {
    A(v, e) = -held_by.stiffness / inertia;
    A(e, v) = 1;
  }
  for (Index i = 0; i < hung; ++i) {
    const auto& r = held_by.resonators[static_cast<std::size_t>(i)];
    const Index speed = hung_from + 2 * i;
    const Index deflection = speed + 1;
    A(v, deflection) = -r.stiffness / inertia;
    A(deflection, v) = 1;
    A(deflection, speed) = -1;
    A(speed, deflection) = static_cast<Long>(r.stiffness) / r.inertia;
  }
  if (device.collocated()) {
    A(y, v) = 1;
  } else {
    A.row(y).head(n) = s.C.row(1).cast<Long>();
    A(y, v) = s.D(1, 1);
    plant.B(y, 0) = s.D(1, 0);
  }
  drop_doubled_position(plant);
  return plant;
}

// e^M, its series after so many halvings that 24 terms suffice.
Matrix exponential(Matrix M) {
  int halvings = 0;
  for (Long size = M.cwiseAbs().rowwise().sum().maxCoeff(); size > 0.5L; size /= 2) ++halvings;
  M /= std::pow(2.0L, static_cast<Long>(halvings));
  Matrix sum = Matrix::Identity(M.rows(), M.cols());
  Matrix term = sum;
  for (int k = 1; k <= 24; ++k) {
    term = term * M / static_cast<Long>(k);
    sum += term;
  }
  for (; halvings > 0; --halvings) sum = sum * sum;
  return sum;
}

// [phi gamma] over an interval with a constant command.
Matrix hold(const Plant& plant, Long interval) {
  const Index n = plant.A.rows();
  Matrix all = Matrix::Zero(n + 1, n + 1);
  all.topLeftCorner(n, n) = plant.A * interval;
  all.topRightCorner(n, 1) = plant.B * interval;
  return exponential(all).topRows(n);
}

Matrix make_loop(const Plant& plant, const Sampling& sampling, const DiscreteStateSpace& law) {
  const std::int64_t whole = floor_divide(sampling.delay, sampling.period);
  if (whole > longest_delay) {
    throw Error(ErrorCode::bad_input, "delay",
                fmt::format("{} periods: at most {} can be checked", whole, longest_delay));
  }
  const Rational rest = sampling.delay - Rational(whole) * sampling.period;
  const auto seconds = [](const Rational& r) { return static_cast<Long>(r.num()) / r.den(); };
  const bool fraction = rest > Rational(0);
  const Index n = plant.A.rows();
  const Index states = law.states();
  const auto under_way = static_cast<Index>(whole) + (fraction ? 1 : 0);
  const Matrix recent = hold(plant, seconds(sampling.period - rest));
  const Matrix late = fraction ? hold(plant, seconds(rest)) : Matrix();
  // Command k = -(C q + D y), then the ones before it.
  Matrix command = Matrix::Zero(under_way + 1, n + states + under_way);
  command.row(0).head(n) = -static_cast<Long>(law.D) * plant.sense;
  command.row(0).segment(n, states) = -law.C.cast<Long>();
  for (Index i = 1; i <= under_way; ++i) command(i, n + states + i - 1) = 1;

  Matrix loop = Matrix::Zero(n + states + under_way, n + states + under_way);
  loop.topLeftCorner(n, n) = recent.leftCols(n);
  if (fraction) {
    loop.topLeftCorner(n, n) = recent.leftCols(n) * late.leftCols(n);
    loop.topRows(n) += recent.leftCols(n) * late.col(n) * command.row(whole + 1);
  }
  loop.topRows(n) += recent.col(n) * command.row(whole);
  loop.block(n, n, states, states) = law.A.cast<Long>();
  loop.block(n, 0, states, n) += law.B.cast<Long>() * plant.sense;
  for (Index i = 0; i < under_way; ++i) loop.row(n + states + i) = command.row(i);
  return loop;
}

}  // namespace

LoopPole find_loop_pole(const HeldDevice& device, const Sampling& sampling,
                        const DiscreteStateSpace& law, const MassSpringDamper& held_by) {
  const Matrix loop = make_loop(make_plant(device, held_by), sampling, law);
  const auto poles = Eigen::EigenSolver<Matrix>(loop, false).eigenvalues();
  LoopPole largest;
  for (const auto& pole : poles) {
    const auto magnitude = static_cast<double>(std::abs(pole));
    if (magnitude > largest.magnitude) {
      largest = {magnitude,
                 static_cast<double>(std::abs(std::arg(pole)) / (2 * std::numbers::pi_v<Long>)) /
                     sampling.period.to_double()};
    }
  }
  return largest;
}

}  // namespace gyrator
