#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"

#include <array>
#include <cstddef>
#include <string_view>

namespace gyrator {

/// How a simulated body moves on by one step h under the effort F:
///   explicit_euler  p' = p + h v,   v' = v + h F(p, v)/m
///   semi_implicit   v' = v + h F(p, v)/m,   p' = p + h v'
///   implicit        v' = v + h F(p', v')/m,   p' = p + h v'                     (integration-1)
/// Of the energy of an oscillation w they make, per step: explicit (w h)^2 of it, semi-implicit
/// none in the mean while w h < 2, implicit -(w h)^2/(1 + (w h)^2).
enum class Integration { explicit_euler, semi_implicit, implicit };
std::string_view name_of(Integration integration);

/// Spring and damper in parallel.
struct SpringDamper {
  double stiffness = 0;  ///< [N/m, N.m/rad]
  double damping = 0;    ///< [N.s/m, N.m.s/rad]
};

/// A spring and damper of a chain. Unilateral: it acts while the left end is beyond the right one,
/// and only pushes them apart.
struct ChainLink {
  SpringDamper law;
  bool unilateral = false;
};

/// One or two simulated bodies between the device and ground,
///   device - link 0 - body 0 - link 1 - (body 1 - link 2 -) ground at `rest`
/// with the effort of link i, between left and right end,
///   e_i = k_i (x_left - x_right) + c_i (v_left - v_right)                             (chain-1)
///   m_i v_i' = e_i - e_{i+1} - b_i v_i
/// At most one link may be unilateral.
struct ChainModel {
  std::size_t bodies = 1;
  std::array<double, 2> inertia{1, 1};  ///< [kg, kg.m^2], above 0
  std::array<double, 2> damping{0, 0};  ///< b_i, to ground [N.s/m, N.m.s/rad]
  std::array<ChainLink, 3> links{};     ///< bodies + 1 of them are used
  double rest = 0;                      ///< where the last link is relaxed [m, rad]
  Integration integration = Integration::semi_implicit;
  int substeps = 1;  ///< into which every step is divided
};

/// Throws bad_input, at controller, for an inertia that is not above 0 and a negative damping,
/// stiffness or number of substeps.
void check_chain(const ChainModel& model);

struct ChainState {
  std::array<double, 2> position{0, 0};
  std::array<double, 2> velocity{0, 0};
};

/// The chain while it runs. Allocates nothing.
class VirtualChain {
 public:
  /// `step` in s.
  VirtualChain(const ChainModel& model, double step);

  const ChainState& state() const { return state_; }
  void place(const ChainState& state) { state_ = state; }

  /// Moves on by one step with the device held at `position` and `velocity`; returns the effort of
  /// link 0 that drove the (last) substep, which opposes the device.
  double advance(double position, double velocity);

  /// Moves on by one step under an effort on the first body, with nothing at link 0.
  void push(double effort);

  /// Gives the last body and its link to ground other values: state and the rest stay.
  void set_last(double inertia, const SpringDamper& to_ground, double rest);

  /// Effort of link 0 between the device there and the first body as it is now.
  double first_effort(double position, double velocity) const;

 private:
  double advance_forward(double position, double velocity);
  double advance_implicit(double position, double velocity);

  ChainModel model_;
  double h_;
  ChainState state_;
  double push_ = 0;
};

/// The chain in contact and at rest = 0 as a linear law from the device's position to the effort
/// of link 0, the device's velocity taken as (y[k] - y[k-1])/step. States: positions, velocities,
/// y[k-1].
DiscreteStateSpace make_chain_law(ChainModel model, double step);

}  // namespace gyrator
