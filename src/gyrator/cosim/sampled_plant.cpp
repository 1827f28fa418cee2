#include "gyrator/cosim/sampled_plant.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;

SplitDelay split_delay(const Sampling& sampling) {
  const std::int64_t whole = floor_divide(sampling.delay, sampling.period);
  const Rational rest = sampling.delay - Rational(whole) * sampling.period;
  return {whole, rest.to_double(), sampling.period.to_double()};
}

SampledPlant sample_plant(const Plant& plant, const Sampling& sampling) {
  if (plant.sensor_position.input.cwiseAbs().maxCoeff() > 0) {
    throw Error(ErrorCode::numerical, "sensor",
                "the sensed position would jump with the command; the drive needs a bandwidth or "
                "the shaft an inertia");
  }
  SampledPlant sampled;
  sampled.delay = split_delay(sampling);
  if (sampled.delay.whole > most_sampled_delay_periods) {
    throw Error(
        ErrorCode::bad_input, "sampling/delay",
        fmt::format("{:g} s, {} sample periods: the loop's eigenvalues are computed for at most {}",
                    sampling.delay.to_double(), sampled.delay.whole, most_sampled_delay_periods));
  }
  sampled.sense = plant.sensor_position.state;
  const MatrixXd command = plant.B.col(0);
  const HeldStep first = discretize_held(plant.A, command, sampled.delay.rest);
  const HeldStep second =
      discretize_held(plant.A, command, sampled.delay.period - sampled.delay.rest);
  sampled.phi = second.phi * first.phi;
  sampled.late = second.phi * first.gamma;
  sampled.recent = second.gamma;
  return sampled;
}

MatrixXd build_loop_matrix(const SampledPlant& plant, const DiscreteStateSpace& law) {
  const Index n = plant.phi.rows();
  const Index nq = law.states();
  const bool fractional = plant.delay.rest > 0;
  const Index held =
      static_cast<Index>(plant.delay.whole) + (fractional ? 1 : 0);  // u[k-1] … u[k-held]
  const Index q0 = n;
  const Index u0 = n + nq;
  MatrixXd loop = MatrixXd::Zero(u0 + held, u0 + held);

  // u[k] = -(C q + D sense ξ), and u[k-j] is the j-th held command.
  RowVectorXd now = RowVectorXd::Zero(loop.cols());
  now.head(n) = -law.D * plant.sense;
  now.segment(q0, nq) = -law.C;
  const auto command = [&](Index age) -> RowVectorXd {
    if (age == 0) return now;
    return RowVectorXd::Unit(loop.cols(), u0 + age - 1);
  };

  const auto whole = static_cast<Index>(plant.delay.whole);
  loop.topLeftCorner(n, n) = plant.phi;
  loop.topRows(n) += plant.recent * command(whole);
  if (fractional) loop.topRows(n) += plant.late * command(whole + 1);
  loop.block(q0, q0, nq, nq) = law.A;
  loop.block(q0, 0, nq, n) += law.B * plant.sense;
  for (Index age = 1; age <= held; ++age) loop.row(u0 + age - 1) = command(age - 1);
  return loop;
}

double compute_spectral_radius(const MatrixXd& loop) {
  if (!loop.allFinite()) return std::numeric_limits<double>::infinity();
  return compute_poles(loop).cwiseAbs().maxCoeff();
}

MatrixXd build_device_loop(const Device& device, const Operator& held_by, const Sampling& sampling,
                           const DiscreteStateSpace& law) {
  const Plant plant = build_plant(build_device_network(device, held_by));
  return build_loop_matrix(sample_plant(plant, sampling), law);
}

double compute_loop_radius(const Device& device, const Operator& held_by, const Sampling& sampling,
                           const DiscreteStateSpace& law) {
  return compute_spectral_radius(build_device_loop(device, held_by, sampling, law));
}

DominantPole find_dominant_pole(const MatrixXd& loop, double period) {
  const Eigen::VectorXcd poles = compute_poles(loop);
  Index at = 0;
  const double magnitude = poles.cwiseAbs().maxCoeff(&at);
  return {magnitude, std::abs(std::arg(poles(at))) / (2 * std::numbers::pi * period)};
}

}  // namespace gyrator
