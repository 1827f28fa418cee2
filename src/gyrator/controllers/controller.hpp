#pragma once

#include "gyrator/controllers/contact_effect.hpp"
#include "gyrator/controllers/deformable.hpp"
#include "gyrator/controllers/passivity_control.hpp"
#include "gyrator/controllers/pre_emphasis.hpp"
#include "gyrator/controllers/predictive_wall.hpp"
#include "gyrator/controllers/virtual_coupling.hpp"
#include "gyrator/controllers/virtual_wall.hpp"
#include "gyrator/controllers/wave_controller.hpp"

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace gyrator {

/// No controller: the command stays zero.
struct NoController {};

/// The closed list of laws, as configuration: what turns a sampled signal into a command.
using Law = std::variant<NoController, VirtualWall, WaveController, PredictiveWall, VirtualCoupling,
                         DirectRendering, ProxyRendering, EquivalentImpedance>;

/// The closed list of what may stand between a law and the converter.
using Wrapper =
    std::variant<PreEmphasis, BrakingPulse, EventTransient, AccelerationMatching, PassivityControl>;

/// A law and what is wrapped around it, from the inside out. Each wrapper sees the sampled signal
/// and the command of what it wraps, and hands on a command of its own.
struct Controller {
  Law law;
  std::vector<Wrapper> wrappers;

  Controller() = default;
  template <class T>
  requires std::constructible_from<Law, T> Controller(T&& given)
      : law(std::forward<T>(given)) {}  // NOLINT: a law is a controller
  Controller(Law given, std::vector<Wrapper> around)
      : law(std::move(given)), wrappers(std::move(around)) {}
};

/// H(z) of the controller, from the sampled signal (position, or the wave's integral) to opposing
/// effort; none for what is not linear (a unilateral wall, an adaptive velocity
/// estimator). `period` in s.
std::optional<DiscreteStateSpace> find_linear_law(const Controller& controller, double period);

/// The linear law that a criterion judges: H itself, and for a unilateral wall the wall that it
/// is while in contact. Wrappers that are not linear are left out. Throws
/// bad_input for a velocity estimator that is not linear: there is no such law.
DiscreteStateSpace make_contact_law(const Controller& controller, double period);

/// The controller that it is while in contact and free to pull, without its wrappers that are not
/// linear: what linear criteria speak of.
Controller keep_in_contact(Controller controller);

/// Whether a wrapper is left out of what linear criteria judge.
bool has_nonlinear_wrapper(const Controller& controller);

/// Whether the law computes its command from a position, so that position and effort are a port
/// whose energy can be observed.
bool reads_position(const Law& law);

/// Whether the law is a surface at position zero, so that there is a moment of contact.
bool has_contact(const Law& law);

/// The linear wrappers in series, applied to the command; a gain of one without any.
DiscreteStateSpace make_output_law(const Controller& controller);

/// Stiffness and virtual damping of the wall that the controller renders, from the position or
/// behind a wave line; none without a wall.
struct WallValues {
  double stiffness = 0;  ///< [N.m/rad, N/m]
  double damping = 0;    ///< [N.m.s/rad, N.s/m]
};
std::optional<WallValues> find_wall_values(const Controller& controller);

/// A controller while it runs: sampled signal in, command out. Allocates only when constructed.
class RunningController {
 public:
  /// `position`: where an environment that keeps a position of its own starts [m, rad].
  RunningController(const Controller& controller, double period, double position = 0);

  double step(double y) {
    double command = std::visit([y](auto& law) { return law.step(y); }, law_);
    if (wrappers_.empty()) return command;
    double effort = command;  // what the wrappers mean to reach the device
    for (auto& wrapper : wrappers_) {
      command = std::visit([&](auto& w) { return w.step(y, command); }, wrapper);
      if (!std::holds_alternative<RunningPreEmphasis>(wrapper)) effort = command;
    }
    tell_law(effort);
    return command;
  }

  /// Names of what law and wrappers tell beside their command (observed energy [J], position of a
  /// simulated tool …), for the trace.
  std::vector<std::string> signal_names() const;
  /// Their values after the last step(), in the same order; allocates nothing once `values` has
  /// that length.
  void read_signals(std::vector<double>& values) const;

 private:
  struct Idle {
    double step(double /*y*/) { return 0; }
  };
  using RunningLaw =
      std::variant<Idle, VirtualWallController, RunningWaveController, RunningPredictiveWall,
                   RunningVirtualCoupling, RunningHeldRendering, RunningEquivalentImpedance>;
  using RunningWrapper =
      std::variant<RunningPreEmphasis, RunningContactEffect, RunningPassivityControl>;

  static RunningLaw make_law(const Law& law, double period, double position);
  static RunningWrapper make_wrapper(const Wrapper& wrapper, const Law& law, double period);

  // A law that reckons with its own command hears what the wrappers made of it.
  void tell_law(double effort) {
    if (auto* wall = std::get_if<RunningPredictiveWall>(&law_)) wall->take_applied(effort);
  }

  RunningLaw law_;
  std::vector<RunningWrapper> wrappers_;
};

}  // namespace gyrator
