#include "gyrator/passivity/port_response.hpp"

#include "gyrator/circuits/descriptor_response.hpp"
#include "gyrator/circuits/reduction.hpp"
#include "gyrator/core/interrupt.hpp"

#include <numbers>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// Columns of `admittance`: command, external effort. Rows: port velocity, sensed velocity.
PortResponse from_admittance(double omega, const Eigen::MatrixXcd& admittance, bool collocated) {
  const Complex y_pu = admittance(0, 0);
  const Complex y_pp = admittance(0, 1);
  PortResponse r{omega, 1.0 / y_pp, y_pu / y_pp, 1.0, 0.0};
  if (!collocated) {
    r.sensor_path = admittance(1, 1) / y_pp;
    r.blocked_motion = admittance(1, 0) - r.sensor_path * y_pu;
  }
  return r;
}

StateSpace make_admittance(const DeviceNetwork& device) {
  const NetworkEquations equations(device.network);
  const Reduction reduction = reduce(equations.descriptor());
  StateSpace system{reduction.A, reduction.B, Eigen::MatrixXd(2, reduction.A.rows()),
                    Eigen::MatrixXd(2, 2)};
  const ReducedForm port = reduction.reduce(equations.across(device.port));
  const ReducedForm sensed = reduction.reduce(find_sensed_rate(device, equations));
  system.C << port.state, sensed.state;
  system.D << port.input, sensed.input;
  return system;
}

Eigen::VectorXcd poles_of(const Device& device, const Operator& held_by) {
  const NetworkEquations equations(build_device_network(device, held_by).network);
  return compute_poles(reduce(equations.descriptor()).A);
}

}  // namespace

std::vector<PortResponse> compute_port_response(const Device& device,
                                                const std::vector<double>& frequency_hz) {
  const DeviceNetwork network = build_device_network(device, FreeOperator{});
  const NetworkEquations equations(network.network);
  const LinearForm port = equations.across(network.port);
  const LinearForm sensed = find_sensed_rate(network, equations);
  DescriptorResponse response(equations.descriptor());
  std::vector<PortResponse> responses;
  responses.reserve(frequency_hz.size());
  for (const double frequency : frequency_hz) {
    throw_if_interrupted("impedance");
    const double omega = 2 * std::numbers::pi * frequency;
    const Eigen::MatrixXcd& x = response.solve(Complex(0, omega));
    Eigen::MatrixXcd admittance(2, x.cols());
    admittance << port.x * x, sensed.x * x;
    responses.push_back(from_admittance(omega, admittance, network.collocated));
  }
  return responses;
}

PortModel::PortModel(const StateSpace& admittance, bool collocated)
    : response_(admittance),
      collocated_(collocated),
      blocked_feedthrough_(collocated ? 0 : admittance.D(1, 0)) {}

PortModel::PortModel(const Device& device)
    : PortModel(make_admittance(build_device_network(device, FreeOperator{})),
                build_device_network(device, FreeOperator{}).collocated) {
  const Eigen::VectorXcd free = poles_of(device, FreeOperator{});
  const Eigen::VectorXcd clamped = poles_of(device, ClampedOperator{});
  poles_.resize(free.size() + clamped.size());
  poles_ << free, clamped;
}

PortResponse PortModel::at(double omega) {
  response_.evaluate(Complex(0, omega), admittance_);
  return from_admittance(omega, admittance_, collocated_);
}

}  // namespace gyrator
