#pragma once

#include "gyrator/mechanics/plant_dynamics.hpp"
#include "gyrator/mechanics/plant_modes.hpp"

#include <memory>
#include <string_view>

#include <Eigen/Dense>

namespace gyrator {

/// How often contacts have switched.
struct ContactEvents {
  long sticks = 0;   ///< the shaft came to rest
  long slips = 0;    ///< the shaft broke away
  long impacts = 0;  ///< the port met a stop

  void count(const ModeGuard& crossed, int from);
};

/// The plant while it runs: state and the energies that have flowed since t = 0 [J].
struct PlantState {
  Eigen::VectorXd xi;
  Modes modes;  ///< of a plant that switches; empty: as ξ tells
  ContactEvents events;
  double operator_work = 0;  ///< done by the operator on the device
  double source_work = 0;    ///< delivered by amplifier and sources
  double dissipated = 0;     ///< heat
};

/// What moves the plant through a segment of constant input. Three of them, one contract:
/// `exact` (matrix exponentials; plants that are linear, or affine in each of their modes), `cvode`
/// (SUNDIALS, the reference), `odeint` (cross-check; knows no friction and stops).
///
/// Order of calls: prepare() once for every segment length that will occur, then advance() any
/// number of times. advance() of `exact` allocates nothing but for each mode that is new to it.
class Engine {
 public:
  explicit Engine(const Plant& plant);
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;
  virtual ~Engine();

  /// Announces a segment length [s]; returns its number for advance().
  virtual int prepare(double interval) = 0;

  /// Moves the state through the segment under u = [command; external effort], and books the
  /// energies if the engine was made with a ledger. `time` [s] is the segment's start, for
  /// messages. Throws numerical (with the time) where an integrator gives up.
  virtual void advance(int segment, double time, const Eigen::Vector2d& u, PlantState& state) = 0;

  /// The same for a length [s] that comes only once (a jittering clock).
  virtual void advance_once(double interval, double time, const Eigen::Vector2d& u,
                            PlantState& state) = 0;

  /// All that signals and energies are functions of beside ξ while u is held: u of a linear plant,
  /// U = [u; contacts; w; 1] of any other (nl-1). Valid until the next call.
  virtual const Eigen::VectorXd& inputs(const Eigen::Vector2d& u, const PlantState& state);

 private:
  Eigen::VectorXd linear_inputs_;
  std::unique_ptr<PlantDynamics> ports_;  ///< of a nonlinear plant
};

enum class EngineKind { exact, cvode, odeint };

struct EngineOptions {
  bool ledger = true;
  double relative_tolerance = 1e-9;  ///< of cvode and odeint
  long max_steps = 100000;           ///< of cvode and odeint, per segment
};

/// The engine that suits a plant: exact where it is linear in pieces, cvode where it is not.
EngineKind choose_engine(const Plant& plant);

std::unique_ptr<Engine> make_engine(EngineKind kind, const Plant& plant,
                                    const EngineOptions& options);

/// Throws bad_input, naming the element, for a plant with a law that is not linear in pieces.
std::unique_ptr<Engine> make_exact_engine(const Plant& plant, const EngineOptions& options);
std::unique_ptr<Engine> make_cvode_engine(const Plant& plant, const EngineOptions& options);
/// Throws bad_input for a plant with friction or stops: it cannot find when they switch.
std::unique_ptr<Engine> make_odeint_engine(const Plant& plant, const EngineOptions& options);
/// The exact engine of plants that switch between affine modes, located to rounding.
std::unique_ptr<Engine> make_hybrid_engine(const Plant& plant, const EngineOptions& options);

/// Typical size of each quantity, from which integrators take their absolute tolerance: the largest
/// that it has had so far, or would have if it held the plant's largest energy alone.
class StateScales {
 public:
  explicit StateScales(const Plant& plant) : plant_(plant) {}

  /// To be called at each segment's start; the energy that u will bring counts already.
  void update(const Eigen::VectorXd& xi, const Eigen::Vector2d& u, double interval);

  const Eigen::VectorXd& states() const { return states_; }
  double energy() const { return energy_; }

 private:
  double energy_of(const Eigen::VectorXd& xi, const Eigen::Vector2d& u);

  const Plant& plant_;
  Eigen::VectorXd states_, z_;
  double energy_ = 0;
};

}  // namespace gyrator
