#include "gyrator/synthesis/operating_extremes.hpp"

#include "gyrator/circuits/descriptor.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr double at_rest_hz = 1e-3;  // far below what any damping circuit does
constexpr int frequencies = 9;

// The unknowns for a velocity of 1 without command, and for a command of 1 with the port held.
struct Responses {
  Eigen::MatrixXcd unknowns, inputs;

  std::complex<double> of(const LinearForm& form, int column) const {
    return (form.x * unknowns.col(column) + form.u * inputs.col(column))(0);
  }
  double worst(const LinearForm& form, const Operation& operation) const {
    return std::abs(of(form, 0)) * operation.speed + std::abs(of(form, 1)) * operation.effort;
  }
};

// The command with the gain that its stage gives it.
Responses solve_responses(const DeviceNetwork& device, const NetworkEquations& equations,
                          double frequency_hz, const CommandStage& stage) {
  const std::complex<double> s(0, 2 * std::numbers::pi * frequency_hz);
  const Eigen::MatrixXcd by_input = solve_descriptor(equations.descriptor(), s);
  const LinearForm velocity = equations.across(device.port);
  const auto velocity_by = [&](int input) { return (velocity.x * by_input.col(input))(0); };
  Eigen::MatrixXcd inputs = Eigen::MatrixXcd::Zero(by_input.cols(), 2);
  inputs(device.external_effort, 0) = 1.0 / velocity_by(device.external_effort);
  const double gain = std::abs(stage.law.response(std::exp(s * stage.period)));
  inputs(device.command, 1) = gain;
  inputs(device.external_effort, 1) =
      -gain * velocity_by(device.command) / velocity_by(device.external_effort);
  return {by_input * inputs, inputs};
}

}  // namespace

OperatingExtremes compute_operating_extremes(const Device& device, std::size_t index,
                                             const Operation& operation,
                                             const CommandStage& stage) {
  const DeviceNetwork network = build_device_network(device, FreeOperator{});
  const NetworkEquations equations(network.network);
  const std::string parts = fmt::format("damping.{}.", index);
  const bool has_amplifier = !std::holds_alternative<IdealDrive>(device.drive.amplifier);
  OperatingExtremes extremes;
  for (int i = 0; i < frequencies; ++i) {
    const double hz =
        at_rest_hz * std::pow(operation.frequency_hz / at_rest_hz, i / (frequencies - 1.0));
    const Responses responses = solve_responses(network, equations, hz, stage);
    const auto raise = [&](double& peak, const LinearForm& form) {
      peak = std::max(peak, responses.worst(form, operation));
    };
    const auto& elements = network.network.elements();
    for (int e = 0; e < static_cast<int>(elements.size()); ++e) {
      const Element& element = elements[static_cast<std::size_t>(e)];
      const ElementId id{e};
      if (has_amplifier && element.name == "amplifier") {
        raise(extremes.amplifier_current, equations.through(id));
        raise(extremes.amplifier_voltage, equations.across(id));
      }
      if (!element.name.starts_with(parts) || element.role != Role::device) continue;
      if (const auto* resistor = std::get_if<Resistor>(&element.law)) {
        const double voltage = responses.worst(equations.across(id), operation);
        extremes.resistor_power =
            std::max(extremes.resistor_power, voltage * voltage / resistor->resistance);
      } else if (std::holds_alternative<Capacitor>(element.law)) {
        raise(extremes.capacitor_voltage, equations.across(id));
      }
    }
  }
  return extremes;
}

}  // namespace gyrator
