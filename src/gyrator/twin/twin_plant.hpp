#pragma once

#include "gyrator/circuits/descriptor.hpp"
#include "gyrator/circuits/reduction.hpp"
#include "gyrator/cosim/engine.hpp"
#include "gyrator/mechanics/plant.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// What is stored where, by the names of the network: the across quantity of a node or the through
/// quantity of a branch [V, A, rad/s, N.m …], none where the network has no such unknown.
struct PhysicalState {
  std::vector<std::string> names;  ///< nodes first, then branches
  std::size_t nodes = 0;
  Eigen::VectorXd values;
  double port_position = 0, sensor_position = 0;
  double output_current = 0;  ///< of the amplifier [A]
  Modes modes;                ///< of friction, stops and ports
  std::vector<std::string> ports;

  std::optional<double> find(std::string_view name, bool is_node) const;
  /// Overrides what a node holds.
  void set_node(const std::string& name, double value);
};

/// A device between two ticks, exactly: its plant, the engine that moves it, and what can be
/// measured of it. One circuit with fixed values; another circuit is another TwinPlant, into which
/// what is stored is carried over.
///
/// The reduced state ξ of a plant has no meaning of its own from one circuit to another. What is
/// carried are the unknowns x of the network by name (red-1), from which the new circuit's own
/// reduction makes ξ = initialize x: charges of capacitors and their signals, fluxes of inductors
/// and momenta, whatever the held input. Where the new circuit contradicts (a current source in
/// series with a winding), its own law wins, as at a switch.
class TwinPlant {
 public:
  /// `split` [s]: a new command takes effect that long after the tick's begin, 0 <= split < tick.
  /// Throws as build_moving_plant(), and bad_input for a circuit that is not linear in pieces.
  TwinPlant(const Device& device, double tick, double split);

  /// Moves by one tick: under `before` [A or V] up to the split, under `after` from there. Returns
  /// the largest terminal voltage [V] right after the command's jump and at the end. Allocates
  /// nothing, but for each mode of friction and rails that is new to it.
  double advance(double time, double before, double after);

  // At the present instant, under the command that was held up to it.
  double current() { return measure(current_); }    ///< in the winding [A]
  double voltage() { return measure(voltage_); }    ///< at the terminals [V]
  double velocity() { return measure(velocity_); }  ///< [rad/s, m/s]
  double position() { return measure(position_); }  ///< [rad, m]
  double stored_energy();                           ///< of the whole device [J]

  PhysicalState physical_state();
  /// Takes over what is stored; `held` [A or V] is the command from now on.
  void set_state(const PhysicalState& from, double held);

  const Plant& plant() const { return plant_; }
  const PlantState& state() const { return state_; }
  /// Goes back to a state of this plant's own, and the command held then.
  void restore(const PlantState& state, double held) {
    state_ = state;
    u_(0) = held;
  }

 private:
  // A signal, and whether contacts or laws must be solved for it beside the command.
  struct Reading {
    Signal signal;
    bool needs_solution = false;
  };
  Reading make_reading(Signal signal) const;
  double measure(const Reading& reading);
  Eigen::VectorXd network_inputs();

  DeviceNetwork network_;
  NetworkEquations equations_;
  Reduction reduction_;
  Plant plant_;
  std::unique_ptr<Engine> engine_;
  Reading current_, voltage_, velocity_, position_;
  ReducedForm output_current_;
  int first_ = -1, second_ = -1;  ///< segments
  Eigen::Vector2d u_ = Eigen::Vector2d::Zero();
  PlantState state_;
};

/// The same with a current amplifier's supply rails, if the device has them. Below them the circuit
/// without rails is the same but for their leakage, has no pole at the rate of a winding behind an
/// almost open switch, and takes a fraction of the time: rails are put in for the ticks in which
/// the terminals would pass them.
class RailedPlant {
 public:
  RailedPlant(const Device& device, double tick, double split);

  void advance(double time, double before, double after);
  TwinPlant& now() { return railed_now_ ? *railed_ : *free_; }
  PhysicalState physical_state() { return now().physical_state(); }
  void set_state(const PhysicalState& from, double held);

 private:
  Device device_;
  double tick_, split_;
  std::optional<double> rails_;  ///< [V]
  std::unique_ptr<TwinPlant> free_, railed_;
  bool railed_now_ = false;
  int calm_ = 0;  ///< ticks below the rails since they were put in
  PlantState before_;
};

}  // namespace gyrator
