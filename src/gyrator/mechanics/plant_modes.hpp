#pragma once

#include "gyrator/mechanics/plant.hpp"

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// The mode of each switching part of a plant: friction, stops, then the ports.
///   friction  0 sticks; +-1 slides that way, up to the Stribeck velocity; +-2 beyond it
///   stops     0 within the range; +-1 on the upper or lower one; +-2 beyond, the stop returning
///   port      0 between its bends, +-1 beyond one
using Modes = std::vector<signed char>;

/// What holds while a mode lasts: row [ξ; U] >= 0. Where it no longer does, `part` becomes `next`.
struct ModeGuard {
  Eigen::RowVectorXd row;
  std::size_t part = 0;
  signed char next = 0;
};

/// A plant (nl-1) in modes. In each of them contacts, and ports where they are piecewise linear,
/// follow linear equations of [ξ; U]:
///   slides    f = -+ (f_s - (f_s - f_c) |v|/v_s), or -+ f_c                       (mode-1)
///   sticks    c dξ/dt = 0, c the row of the shaft's velocity; v = 0
///   touches   e = -(k q + d v), q the deflection; otherwise e = 0
///   port      w = s y + o
/// Both engines take equations and guards from here. A shaft that nothing can move (clamped) knows
/// no friction.
class PlantModes {
 public:
  /// `plant` must have a nonlinear part and outlive this. Without ports, only contacts switch.
  PlantModes(const Plant& plant, bool with_ports);

  std::size_t size() const { return names_.size(); }
  bool has_ports() const { return ports_ > 0; }
  std::size_t first_port() const { return 2; }
  const std::string& name(std::size_t part) const { return names_[part]; }

  /// Modes at ξ where nothing else is known: ports between their bends.
  Modes start(const Eigen::VectorXd& xi) const;

  /// The mode of a port at its argument.
  signed char mode_of_port(std::size_t port, double argument) const;

  /// U as a function of all else in [ξ; U], U = closed [ξ; U with contacts (and ports) zero].
  Eigen::MatrixXd close(const Modes& modes) const;

  std::vector<ModeGuard> guards(const Modes& modes) const;

  /// Whether a guard's crossing means that the shaft has come to v = 0.
  bool comes_to_rest(const ModeGuard& guard) const { return guard.part == 0 && guard.next == 0; }
  bool sticks(const Modes& modes) const { return friction_ && modes.front() == 0; }
  /// Takes the rounding out of v = 0 in a state, or out of the rate of v in the columns of one.
  void hold_shaft(Eigen::Ref<Eigen::MatrixXd> states) const;

 private:
  Eigen::RowVectorXd row(const Eigen::RowVectorXd& state, Eigen::Index input, double by) const;
  Eigen::MatrixXd equations(const Modes& modes) const;
  void add_friction_guards(int mode, std::vector<ModeGuard>& guards) const;
  void add_stop_guards(int mode, std::vector<ModeGuard>& guards) const;
  Eigen::RowVectorXd deflection(int side) const;

  const NonlinearPart& nl_;
  Eigen::Index n_, m_;
  std::size_t ports_ = 0;
  std::optional<DryFriction> friction_;
  std::optional<HardStops> stops_;
  Eigen::RowVectorXd shaft_velocity_, port_position_, port_velocity_;  ///< of ξ
  Eigen::Index shaft_state_ = -1;  ///< where one state is the shaft's velocity
  Eigen::VectorXd push_;           ///< dξ/dt per effort of friction
  std::vector<std::string> names_;
};

}  // namespace gyrator
