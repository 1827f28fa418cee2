#pragma once

#include "gyrator/controllers/slow_clock.hpp"
#include "gyrator/controllers/virtual_chain.hpp"

#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// What a simulated tool meets: spring and damper to ground at a position.
struct ToolWall {
  SpringDamper law;
  double position = 0;      ///< [m, rad]
  bool unilateral = false;  ///< acts for a tool beyond `position` only, and only pushes it back
};

/// A spring and damper between the device and a simulated tool:
///   F = K_c (y - p) + B_c (v - w),   command = -F                                  (coupling-1)
///   m w' = F - b_t w - F_e(p, w)
/// y, v position and backward-difference velocity of the device, p, w of the tool, K_c [N/m],
/// B_c [N.s/m], m tool's mass [kg], b_t its damping to ground (N.m/rad … in rotation), F_e effort
/// of the wall that it meets. The device starts with the tool where it is.
///
/// In the loop (no `update`) the F that opposes the device is the one that moves the tool through
/// the step. Behind it, at the update's period P, the tool is moved by the F of its own last sample
/// of y, with v over P; the fast loop computes F from what it knew last of p and w.
/// Source: [8.5.1], Colgate et al. 1995; integration schemes Brown and Colgate 1998.
struct VirtualCoupling {
  SpringDamper coupling;
  double tool_inertia = 1;  ///< [kg, kg.m^2]
  double tool_damping = 0;  ///< [N.s/m, N.m.s/rad]
  std::optional<ToolWall> wall;
  Integration integration = Integration::semi_implicit;
  int substeps = 1;
  SlowUpdate update;
};

/// H(z) from position to opposing effort with the tool in contact with its wall, if there is one.
/// Throws bad_input for what is computed at a slower rate or arrives late: that has none.
DiscreteStateSpace make_coupling_law(const VirtualCoupling& coupling, double period);

/// The running coupling. `step` allocates nothing.
class RunningVirtualCoupling {
 public:
  RunningVirtualCoupling(const VirtualCoupling& coupling, double period);

  /// Command for the sampled position y.
  double step(double y);

  double tool_position() const { return tool_.state().position[0]; }  ///< [m, rad]

  void append_signal_names(std::vector<std::string>& names) const {
    names.emplace_back("tool_position");
  }
  double* write_signals(double* value) const {
    *value = tool_position();
    return value + 1;
  }

 private:
  struct Tool {
    double position = 0, velocity = 0;
  };

  SpringDamper coupling_;
  double period_;
  bool immediate_;
  SlowLink<Tool> link_;
  VirtualChain tool_;
  double last_ = 0, last_slow_ = 0;
  bool started_ = false;
};

}  // namespace gyrator
