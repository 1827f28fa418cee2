#include "gyrator/tuning/step_images.hpp"

#include "gyrator/cosim/hold.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/mechanics/plant.hpp"
#include "gyrator/tuning/settings_choice.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

}  // namespace

Tone remove_step_images(const Tone& tone, const Device& device, double tick, double delay) {
  const double omega = 2 * std::numbers::pi * tone.frequency_hz;
  const Complex s(0, omega);
  const Complex hold = compute_normalized_hold(omega, tick);
  Tone smooth = tone;
  smooth.command.value *= hold;
  smooth.command.deviation *= std::abs(hold);
  if (!find_bandwidth(device.drive.amplifier)) return smooth;

  const Plant plant = build_plant(build_device_network(device, FreeOperator{}, 1));
  Sampling sampling;
  // Of a whole number of nanoseconds, which no amplifier's delay is known to.
  sampling.period = Rational{std::llround(tick * 1e9), 1000000000};
  sampling.delay = Rational{std::llround(delay * 1e9), 1000000000};
  const SampledPlant sampled = sample_plant(plant, sampling);
  const Complex z = std::polar(1.0, omega * tick);
  const auto identity = Eigen::MatrixXcd::Identity(plant.states(), plant.states());
  const Eigen::VectorXcd fundamental =
      (s * identity - plant.A).fullPivLu().solve(Eigen::VectorXcd(plant.B.col(0))) * hold *
      std::polar(1.0, -omega * delay);
  const double m = static_cast<double>(sampled.delay.whole);
  const Eigen::VectorXcd input =
      sampled.late * std::pow(z, -m - 1) + sampled.recent * std::pow(z, -m);
  const Eigen::VectorXcd at_ticks = (z * identity - sampled.phi).fullPivLu().solve(input);

  const auto correct = [&](Phasor& phasor, const Eigen::RowVectorXd& row) {
    const Complex seen = (row * at_ticks)(0);
    if (std::abs(seen) == 0) return;
    const Complex factor = (row * fundamental)(0) / seen;
    phasor.value *= factor;
    phasor.deviation *= std::abs(factor);
  };
  correct(smooth.velocity, plant.port_velocity.state);
  Eigen::RowVectorXd current = Eigen::RowVectorXd::Zero(plant.states());
  for (const Signal& signal : plant.others) {
    if (signal.name != "current") continue;
    current = signal.state;
    correct(smooth.current, current);
  }
  for (const Signal& signal : plant.others) {
    if (signal.name != "voltage") continue;
    // Across the motor: what the amplifier adds to cancel resistance is behind the terminals.
    const Eigen::RowVectorXd across =
        signal.state + find_cancelled_resistance(device.drive) * current;
    correct(smooth.voltage, across);
  }
  return smooth;
}

}  // namespace gyrator
