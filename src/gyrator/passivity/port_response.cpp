#include "gyrator/passivity/port_response.hpp"

#include "gyrator/circuits/descriptor_response.hpp"
#include "gyrator/circuits/reduction.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/core/plain_complex.hpp"

#include <numbers>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// Columns of `admittance`: command, external effort. Rows: port velocity, sensed velocity.
PortResponse from_admittance(double omega, const Eigen::MatrixXcd& admittance,
                             const DeviceNetwork& device) {
  const Complex y_pu = admittance(0, 0);
  const Complex y_pp = admittance(0, 1);
  PortResponse r{omega, 1.0 / y_pp, y_pu / y_pp, 1.0, 0.0};
  if (!device.collocated) {
    r.sensor_path = admittance(1, 1) / y_pp;
    // Behind a filter at the port M is zero, not the rounding of a difference.
    if (!device.port_sensed) r.blocked_motion = admittance(1, 0) - r.sensor_path * y_pu;
  }
  return r;
}

// A source moves the port. What it feels of its own acceleration is the inertia that is rigid with
// it.
BlockedDevice block_port(const Device& device) {
  DeviceNetwork held = build_device_network(device, FreeOperator{});
  const int velocity = held.network.add_input("velocity");
  const ElementId source = held.network.add("operator.motion", held.port, ground,
                                            VoltageSource{velocity}, Role::operator_side);
  const NetworkEquations equations(held.network);
  const Reduction reduction = reduce(equations.descriptor());
  // Through the source flows what it takes from the port: the effort of the hand on it, turned.
  const ReducedForm effort = reduction.reduce(equations.through(source));
  const ReducedForm sensed = reduction.reduce(find_sensed_rate(held, equations));
  if (!held.collocated && sensed.input_rate.cwiseAbs().maxCoeff() > 0) {
    throw Error(ErrorCode::numerical, "sensor",
                "what is sensed would follow the port's acceleration at once");
  }
  BlockedDevice blocked;
  blocked.inertia = -effort.input_rate(velocity);
  blocked.sensed_at_port = held.port_sensed;
  const Eigen::Index outputs = held.collocated ? 1 : 2;
  StateSpace& system = blocked.system;
  system.A = reduction.A;
  system.B.resize(system.A.rows(), 2);
  system.B << reduction.B.col(held.command), reduction.B.col(velocity);
  system.C.resize(outputs, system.A.rows());
  system.D.resize(outputs, 2);
  system.C.row(0) = -effort.state;
  system.D.row(0) << -effort.input(held.command), -effort.input(velocity);
  if (!held.collocated) {
    system.C.row(1) = sensed.state;
    system.D.row(1) << sensed.input(held.command), sensed.input(velocity);
  }
  return blocked;
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
    throw_if_interrupted("frequency response");
    const double omega = 2 * std::numbers::pi * frequency;
    const Eigen::MatrixXcd& x = response.solve(Complex(0, omega));
    Eigen::MatrixXcd admittance(2, x.cols());
    admittance << port.x * x, sensed.x * x;
    responses.push_back(from_admittance(omega, admittance, network));
  }
  return responses;
}

PortModel::PortModel(const Device& device)
    : blocked_(block_port(device)),
      response_(blocked_.system),
      modes_(ModalResponse::find(blocked_.system)),
      blocked_feedthrough_(sees_no_command() ? 0 : blocked_.system.D(1, 0)) {
  const Eigen::VectorXcd free = poles_of(device, FreeOperator{});
  const Eigen::VectorXcd clamped = compute_poles(blocked_.system.A);
  poles_.resize(free.size() + clamped.size());
  poles_ << free, clamped;
}

PortResponse PortModel::at(double omega) {
  ModalResponse::Entries y{};
  if (modes_ && omega <= modes_->highest()) {
    y = modes_->at(omega);
  } else {
    response_.evaluate(Complex(0, omega), entries_);
    for (Eigen::Index r = 0; r < entries_.rows(); ++r) {
      for (Eigen::Index c = 0; c < 2; ++c) y[static_cast<std::size_t>(2 * r + c)] = entries_(r, c);
    }
  }
  PortResponse response{omega, y[1] + Complex(0, omega * blocked_.inertia), -y[0], 1.0, 0.0};
  if (!collocated()) {
    response.sensor_path = y[3];
    if (!sees_no_command()) response.blocked_motion = y[2];
  }
  return response;
}

}  // namespace gyrator
