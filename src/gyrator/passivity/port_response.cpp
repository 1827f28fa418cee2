#include "gyrator/passivity/port_response.hpp"

#include "gyrator/circuits/descriptor_response.hpp"
#include "gyrator/circuits/reduction.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/core/plain_complex.hpp"

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

// From free to blocked: dv/dt = C A x + C B_f f + C B_u u is solved for f. The state loses the
// direction that v itself fixes, x = w + B_f v/(C B_f) with C w = 0; of w the component with the
// largest entry in C is left out.
BlockedDevice block_port(const StateSpace& free, bool collocated) {
  const Eigen::VectorXd by_command = free.B.col(0);
  const Eigen::VectorXd by_effort = free.B.col(1);
  const Eigen::RowVectorXd port = free.C.row(0);
  BlockedDevice blocked;
  blocked.inertia = 1 / port.dot(by_effort);
  const double m = blocked.inertia;
  const Eigen::RowVectorXd drift = m * port * free.A;
  const Eigen::MatrixXd A = free.A - by_effort * drift;
  const Eigen::VectorXd command = by_command - by_effort * (m * port.dot(by_command));
  const Eigen::VectorXd velocity = A * by_effort * m;

  Eigen::Index fixed = 0;
  port.cwiseAbs().maxCoeff(&fixed);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    if (i != fixed) kept.push_back(i);
  }
  const auto n = static_cast<Eigen::Index>(kept.size());
  Eigen::MatrixXd embed = Eigen::MatrixXd::Zero(A.rows(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index i = kept[static_cast<std::size_t>(k)];
    embed(i, k) = 1;
    embed(fixed, k) = -port(i) / port(fixed);
  }
  StateSpace& system = blocked.system;
  system.A = A(kept, Eigen::all) * embed;
  system.B.resize(n, 2);
  system.B << command(kept), velocity(kept);
  const Eigen::Index outputs = collocated ? 1 : 2;
  system.C.resize(outputs, n);
  system.D.resize(outputs, 2);
  system.C.row(0) = -drift * embed;
  system.D.row(0) << -m * port.dot(by_command), -m * drift.dot(by_effort);
  if (!collocated) {
    system.C.row(1) = free.C.row(1) * embed;
    system.D.row(1) << free.D(1, 0), m * free.C.row(1).dot(by_effort);
  }
  return blocked;
}

BlockedDevice block_port(const Device& device) {
  const DeviceNetwork network = build_device_network(device, FreeOperator{});
  return block_port(make_admittance(network), network.collocated);
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

PortModel::PortModel(const Device& device)
    : blocked_(block_port(device)),
      response_(blocked_.system),
      modes_(ModalResponse::find(blocked_.system)),
      blocked_feedthrough_(collocated() ? 0 : blocked_.system.D(1, 0)) {
  const Eigen::VectorXcd free = poles_of(device, FreeOperator{});
  const Eigen::VectorXcd clamped = poles_of(device, ClampedOperator{});
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
    response.blocked_motion = y[2];
  }
  return response;
}

}  // namespace gyrator
