#include "gyrator/mechanics/plant.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/mechanics/plant_assembly.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrator {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

MatrixXd grow_form(const MatrixXd& form, Index at) {
  MatrixXd grown = MatrixXd::Zero(form.rows() + 1, form.cols() + 1);
  const Index tail = form.rows() - at;
  grown.topLeftCorner(at, at) = form.topLeftCorner(at, at);
  grown.bottomRightCorner(tail, tail) = form.bottomRightCorner(tail, tail);
  grown.topRightCorner(at, tail) = form.topRightCorner(at, tail);
  grown.bottomLeftCorner(tail, at) = form.bottomLeftCorner(tail, at);
  return grown;
}

RowVectorXd grow_row(const RowVectorXd& row) {
  RowVectorXd grown = RowVectorXd::Zero(row.size() + 1);
  grown.head(row.size()) = row;
  return grown;
}

namespace {

// A row g with g A = velocity and g B = velocity_input, where the state holds the position already.
std::optional<RowVectorXd> find_held_position(const MatrixXd& A, const MatrixXd& B,
                                              const Signal& velocity) {
  const Index n = A.rows();
  if (n == 0) return std::nullopt;
  MatrixXd equations(A.cols() + B.cols(), n);
  equations << A.transpose(), B.transpose();
  VectorXd wanted(A.cols() + B.cols());
  wanted << velocity.state.transpose(), velocity.input.transpose();
  // Rows differ by their units: scale each to one before asking whether they can all be met.
  for (Index i = 0; i < equations.rows(); ++i) {
    const double size = std::max(equations.row(i).cwiseAbs().maxCoeff(), std::abs(wanted(i)));
    if (size > 0) {
      equations.row(i) /= size;
      wanted(i) /= size;
    }
  }
  const VectorXd columns = equations.colwise().norm().transpose().cwiseMax(1e-300);
  const MatrixXd scaled = equations * columns.cwiseInverse().asDiagonal();
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition(scaled);
  VectorXd g = decomposition.solve(wanted);
  if ((scaled * g - wanted).norm() > 1e-10 * wanted.norm()) return std::nullopt;
  // States that take no part have been left with rounding: a run from rest would start with it.
  g = (g.array().abs() < 1e-12 * g.cwiseAbs().maxCoeff()).select(0, g).eval();
  return RowVectorXd((g.array() / columns.array()).transpose());
}

// Position as the integral of a velocity: held by the state, or appended as a state of its own.
Signal append_position(Plant& plant, std::string name, const Signal& velocity,
                       std::vector<Signal*> signals) {
  if (const auto held = find_held_position(plant.A, plant.B, velocity)) {
    return {std::move(name), *held, RowVectorXd::Zero(plant.B.cols())};
  }
  const Index n = plant.A.rows();
  MatrixXd A = MatrixXd::Zero(n + 1, n + 1);
  A.topLeftCorner(n, n) = plant.A;
  A.row(n).head(n) = velocity.state;
  MatrixXd B(n + 1, plant.B.cols());
  B << plant.B, velocity.input;
  plant.A = A;
  plant.B = B;
  for (Signal* signal : signals) signal->state = grow_row(signal->state);
  for (auto& signal : plant.others) signal.state = grow_row(signal.state);
  auto& e = plant.energy;
  for (MatrixXd* form : {&e.stored, &e.dissipated, &e.source, &e.operator_work, &e.source_jump}) {
    *form = grow_form(*form, n);
  }
  RowVectorXd row = RowVectorXd::Zero(n + 1);
  row(n) = 1;
  return {std::move(name), row, RowVectorXd::Zero(plant.B.cols())};
}

Signal as_signal(std::string name, const ReducedForm& form) {
  return {std::move(name), form.state, form.input};
}

// The unknowns after a slow rigid displacement by one: what integrates the velocities `moving`.
VectorXd displace(const DeviceNetwork& device, const NetworkEquations& equations,
                  const VectorXd& moving) {
  VectorXd displaced = VectorXd::Zero(moving.size());
  const auto& elements = device.network.elements();
  for (int e = 0; e < static_cast<int>(elements.size()); ++e) {
    const Element& element = elements[static_cast<std::size_t>(e)];
    const auto* spring = std::get_if<Inductor>(&element.law);
    if (!spring) continue;
    const double rate = equations.across(ElementId{e}).x.dot(moving);
    displaced += equations.through(ElementId{e}).x.transpose() * (rate / spring->inductance);
  }
  for (const NodeId position : device.drive.positions)
    displaced += equations.across(position).x.transpose();
  return displaced;
}

}  // namespace

Plant assemble_plant(const DeviceNetwork& device, const NetworkEquations& equations,
                     const Reduction& reduction) {
  Plant plant;
  plant.A = reduction.A;
  plant.B = reduction.B;
  plant.energy = build_energy_forms(equations, reduction, device.operator_ammeter);

  const auto read = [&](std::string name, const LinearForm& form) {
    const ReducedForm reduced = reduction.reduce(form);
    if (!reduced.state.allFinite() || reduced.input_rate.cwiseAbs().maxCoeff() >
                                          1e-9 * (1 + reduced.input.cwiseAbs().maxCoeff())) {
      throw Error(
          ErrorCode::numerical, name,
          "would need the derivative of the command: a step of it gives an impulse here; add the "
          "amplifier's bandwidth, a resistance or a compliance that the real device has");
    }
    return as_signal(std::move(name), reduced);
  };
  plant.port_velocity = read("velocity", equations.across(device.port));
  Signal sensor_velocity = read("sensor_velocity", find_sensed_rate(device, equations));
  plant.port_effort = read("effort", equations.through(device.operator_ammeter));
  const auto read_if_finite = [&](std::string name, const LinearForm& form) {
    const ReducedForm reduced = reduction.reduce(form);
    if (reduced.input_rate.isZero(1e-12))
      plant.others.push_back(as_signal(std::move(name), reduced));
  };
  if (device.drive.motor_ammeter)
    read_if_finite("current", equations.through(*device.drive.motor_ammeter));
  if (device.drive.terminal) read_if_finite("voltage", equations.across(*device.drive.terminal));

  // At rest electrically, every inertia at the given velocity: of all unknowns only the
  // mechanical node velocities are set, and what the sensor's filter makes of a steady one.
  VectorXd moving = VectorXd::Zero(equations.descriptor().size());
  const auto& nodes = device.network.nodes();
  for (std::size_t node = 1; node < nodes.size(); ++node) {
    if (nodes[node].domain == Domain::mechanical) moving(static_cast<Index>(node) - 1) = 1;
  }
  for (const NodeId node : device.filter) moving(node.index - 1) = 1;
  const VectorXd at_velocity = reduction.initialize * moving;

  // The network may hold the second of the two in terms of the first. A position is at its best as
  // a state or a spring of its own, so that the wave's integral comes after it, and so does a
  // filtered position, which is the true one less what the filter's state trails it by.
  const bool wave = device.sensor == SensorLocation::outgoing_wave;
  const bool sensed_first = !wave && device.filter.empty();
  if (sensed_first) {
    plant.sensor_position =
        append_position(plant, "sensor_position", sensor_velocity,
                        {&plant.port_velocity, &plant.port_effort, &sensor_velocity});
  }
  if (device.collocated) {
    plant.port_position = plant.sensor_position;
    plant.port_position.name = "position";
  } else {
    std::vector<Signal*> others{&plant.port_velocity, &plant.port_effort, &sensor_velocity};
    if (sensed_first) others.push_back(&plant.sensor_position);
    plant.port_position = append_position(plant, "position", plant.port_velocity, others);
  }
  const Index before_wave = plant.A.rows();
  if (!sensed_first) {
    plant.sensor_position = append_position(
        plant, wave ? wave_integral_name : "sensor_position", sensor_velocity,
        {&plant.port_velocity, &plant.port_effort, &plant.port_position, &sensor_velocity});
  }

  // A rigid displacement deflects the springs to ground and moves every position, those appended
  // above included; that of the sensor exactly so.
  plant.rest = MatrixXd::Zero(plant.A.rows(), 2);
  plant.rest.col(1).head(at_velocity.size()) = at_velocity;
  plant.rest.col(0).setOnes();
  plant.rest.col(0).head(at_velocity.size()) =
      reduction.initialize * displace(device, equations, moving);
  const double moved = plant.port_position.state.dot(plant.rest.col(0));
  if (moved != 0) {
    plant.rest.col(0) /= moved;
  } else {
    plant.rest.col(0).setZero();  // a clamped port stays at zero
  }
  if (wave && plant.A.rows() > before_wave) plant.rest(before_wave, 0) = 0;
  return plant;
}

Plant build_plant(const DeviceNetwork& device) {
  const NetworkEquations equations(device.network);
  return assemble_plant(device, equations, reduce(equations.descriptor()));
}

}  // namespace gyrator
