#include "gyrator/twin/twin_plant.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

// The equations whose reduction is the plant's own: contacts add inputs only.
NetworkEquations equations_of(const DeviceNetwork& device) {
  const bool moving = !device.network.is_linear() || device.friction || device.stops;
  return moving ? NetworkEquations::with_ports(device.network) : NetworkEquations(device.network);
}

[[noreturn]] void refuse_impulse(std::string_view name) {
  throw Error(ErrorCode::numerical, "twin",
              std::string(name) +
                  " has an impulse at every step of the command in this circuit: give the circuit "
                  "the resistance or inductance that the real one has");
}

Signal find_signal(const Plant& plant, std::string_view name) {
  for (const Signal& signal : plant.others)
    if (signal.name == name) return signal;
  refuse_impulse(name);
}

// The rate of the sensed position.
Signal differentiate(const Plant& plant) {
  const MatrixXd& A = plant.nonlinear ? plant.nonlinear->A : plant.A;
  const MatrixXd& B = plant.nonlinear ? plant.nonlinear->B : plant.B;
  const RowVectorXd& position = plant.sensor_position.state;
  return {"sensor_velocity", position * A, position * B};
}

// Across the motor itself: with what the amplifier adds to cancel resistance.
Signal find_winding_voltage(const Plant& plant, const DeviceNetwork& device,
                            const NetworkEquations& equations, const Reduction& reduction) {
  const auto& winding = device.network.element(*device.network.find_element("motor.resistance"));
  const ReducedForm form = reduction.reduce(equations.across(winding.positive));
  if (!form.input_rate.isZero(1e-12)) refuse_impulse("voltage");
  // The plant has more of both: positions, and the efforts of contacts before the ports (nl-1).
  Signal signal{"voltage", RowVectorXd::Zero(plant.states()), RowVectorXd::Zero(plant.inputs())};
  signal.state.head(form.state.size()) = form.state;
  signal.input.head(2) = form.input.head(2);
  if (plant.nonlinear) {
    const Index ports = form.input.size() - 2;
    signal.input.segment(plant.nonlinear->first_port(), ports) = form.input.tail(ports);
  }
  return signal;
}

// The current that leaves the amplifier [A]: the voltage source is measured into its output.
ReducedForm find_output_current(const DeviceNetwork& device, const NetworkEquations& equations,
                                const Reduction& reduction) {
  const auto amplifier = device.network.find_element("amplifier");
  ReducedForm form = reduction.reduce(equations.through(*amplifier));
  const auto& law = device.network.element(*amplifier).law;
  if (std::holds_alternative<VoltageControlledVoltageSource>(law)) {
    form.state = -form.state;
    form.input = -form.input;
  }
  return form;
}

}  // namespace

std::optional<double> PhysicalState::find(std::string_view name, bool is_node) const {
  const std::size_t from = is_node ? 0 : nodes;
  const std::size_t to = is_node ? nodes : names.size();
  for (std::size_t i = from; i < to; ++i)
    if (names[i] == name) return values(static_cast<Index>(i));
  return std::nullopt;
}

void PhysicalState::set_node(const std::string& name, double value) {
  for (std::size_t i = 0; i < nodes; ++i) {
    if (names[i] != name) continue;
    values(static_cast<Index>(i)) = value;
    return;
  }
  names.insert(names.begin(), name);
  ++nodes;
  VectorXd grown(values.size() + 1);
  grown << value, values;
  values = std::move(grown);
}

TwinPlant::TwinPlant(const Device& device, double tick, double split)
    : network_(build_device_network(device, FreeOperator{}, 1)),
      equations_(equations_of(network_)),
      reduction_(reduce(equations_.descriptor())),
      plant_(build_moving_plant(network_)),
      engine_(make_exact_engine(plant_, {.ledger = false})),
      current_(make_reading(find_signal(plant_, "current"))),
      voltage_(make_reading(find_winding_voltage(plant_, network_, equations_, reduction_))),
      velocity_(make_reading(differentiate(plant_))),
      position_(make_reading(plant_.sensor_position)),
      output_current_(find_output_current(network_, equations_, reduction_)) {
  if (split > 0) first_ = engine_->prepare(split);
  second_ = engine_->prepare(tick - split);
  state_.xi = plant_.initial_state(0, 0);
}

TwinPlant::Reading TwinPlant::make_reading(Signal signal) const {
  constexpr double rounding = 1e-12;
  const double size = 1 + signal.state.cwiseAbs().maxCoeff();
  signal.input = (signal.input.array().abs() > rounding * size).select(signal.input, 0);
  const bool needs_solution = !signal.input.tail(signal.input.size() - 2).isZero(0);
  return {std::move(signal), needs_solution};
}

double TwinPlant::advance(double time, double before, double after) {
  if (first_ >= 0) {
    u_(0) = before;
    engine_->advance(first_, time, u_, state_);
  }
  u_(0) = after;
  const double at_jump = std::abs(voltage());
  engine_->advance(second_, time, u_, state_);
  return std::max(at_jump, std::abs(voltage()));
}

double TwinPlant::measure(const Reading& reading) {
  const Signal& signal = reading.signal;
  const double of_state = signal.state.dot(state_.xi);
  if (!reading.needs_solution) return of_state + signal.input.head(2).dot(u_);
  return of_state + signal.input.dot(engine_->inputs(u_, state_));
}

double TwinPlant::stored_energy() {
  const VectorXd& inputs = engine_->inputs(u_, state_);
  VectorXd z(state_.xi.size() + inputs.size());
  z << state_.xi, inputs;
  return z.dot(plant_.energy.stored * z);
}

// U without the contacts, which are no inputs of the network's own equations.
VectorXd TwinPlant::network_inputs() {
  const VectorXd& all = engine_->inputs(u_, state_);
  if (!plant_.nonlinear) return all;
  const Index first = plant_.nonlinear->first_port();
  const Index rest = all.size() - first;
  VectorXd inputs(2 + rest);
  inputs << all.head(2), all.tail(rest);
  return inputs;
}

PhysicalState TwinPlant::physical_state() {
  const Descriptor& descriptor = equations_.descriptor();
  const VectorXd inputs = network_inputs();
  const VectorXd reduced = state_.xi.head(reduction_.A.rows());
  PhysicalState physical;
  physical.names = descriptor.unknown_names;
  physical.nodes = network_.network.nodes().size() - 1;
  physical.values = reduction_.recover_state * reduced + reduction_.recover_input * inputs;
  physical.port_position = plant_.port_position.state.dot(state_.xi);
  physical.sensor_position = position();
  physical.output_current = output_current_.state.dot(reduced) + output_current_.input.dot(inputs);
  physical.modes = state_.modes;
  if (plant_.nonlinear) {
    physical.ports = {"contacts"};
    for (const auto& port : plant_.nonlinear->ports) physical.ports.push_back(port.element);
  }
  return physical;
}

void TwinPlant::set_state(const PhysicalState& from, double held) {
  const Descriptor& descriptor = equations_.descriptor();
  const std::size_t nodes = network_.network.nodes().size() - 1;
  VectorXd x = VectorXd::Zero(descriptor.size());
  for (Index j = 0; j < x.size(); ++j) {
    if (descriptor.E.col(j).isZero(0)) continue;  // stores nothing
    const auto i = static_cast<std::size_t>(j);
    x(j) = from.find(descriptor.unknown_names[i], i < nodes).value_or(0);
  }
  const Index reduced = reduction_.A.rows();
  const Index appended = plant_.states() - reduced;
  state_ = {};
  state_.xi = VectorXd::Zero(plant_.states());
  state_.xi.head(reduced) = reduction_.initialize * x;
  if (appended > 0) {
    // What the network does not hold of the positions are states of their own.
    MatrixXd rows(2, appended);
    rows << plant_.port_position.state.tail(appended), plant_.sensor_position.state.tail(appended);
    Eigen::Vector2d missing(from.port_position, from.sensor_position);
    missing(0) -= plant_.port_position.state.head(reduced).dot(state_.xi.head(reduced));
    missing(1) -= plant_.sensor_position.state.head(reduced).dot(state_.xi.head(reduced));
    state_.xi.tail(appended) = rows.completeOrthogonalDecomposition().solve(missing);
  }
  u_ = {held, 0};
  if (!plant_.nonlinear) return;
  std::vector<std::string> ports{"contacts"};
  for (const auto& port : plant_.nonlinear->ports) ports.push_back(port.element);
  if (ports == from.ports) state_.modes = from.modes;
}

RailedPlant::RailedPlant(const Device& device, double tick, double split)
    : device_(device), tick_(tick), split_(split) {
  Device without = device;
  if (auto* amplifier = std::get_if<CurrentAmplifier>(&without.drive.amplifier)) {
    rails_ = amplifier->voltage_limit;
    amplifier->voltage_limit = std::nullopt;
  }
  free_ = std::make_unique<TwinPlant>(without, tick, split);
}

void RailedPlant::set_state(const PhysicalState& from, double held) {
  railed_now_ = false;
  free_->set_state(from, held);
}

void RailedPlant::advance(double time, double before, double after) {
  constexpr int calm_ticks = 10;
  if (!rails_) {
    free_->advance(time, before, after);
    return;
  }
  if (!railed_now_) {
    before_ = free_->state();
    if (free_->advance(time, before, after) <= *rails_) return;
    free_->restore(before_, before);
    if (!railed_) railed_ = std::make_unique<TwinPlant>(device_, tick_, split_);
    railed_->set_state(free_->physical_state(), before);
    railed_now_ = true;
    calm_ = 0;
  }
  calm_ = railed_->advance(time, before, after) < *rails_ ? calm_ + 1 : 0;
  if (calm_ < calm_ticks) return;
  free_->set_state(railed_->physical_state(), after);
  railed_now_ = false;
}

}  // namespace gyrator
