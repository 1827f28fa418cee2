#pragma once

#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// Damping that is added to a controller's effort only while its observed energy falls short.
///
/// With f_2 the opposing effort that the wrapped controller asks for, f_1 = f_2 + f_pc what is
/// commanded, x the sampled position and Δx(k) = x(k) - x(k-1), the energy that has flowed into the
/// environment is, with an ideal drive and without delay, exactly
///   E(k) = sum over j <= k of f_1(j-1) Δx(j)                                       [8.34] (pc-1)
/// and the shortfall W that is made good within the coming step, if it is like the last one,
///   simple      W = E(k) + f_2(k) Δx(k)                                            [8.32] (pc-2)
///   reference   W = E(k) + S_0 - max(S + D, 0)                                     [8.35] (pc-3)
///   f_pc(k) = -W/Δx(k) where W < 0 and Δx(k) != 0, else 0                                 (pc-4)
/// S is what the environment would store in continuous time, D what it would have dissipated since
/// the start: K x^2/2 and sum B Δx^2/T while in contact for a wall, with S_0 the S of the first
/// sample; for any other law the sum of (f_2(j-1) + f_2(j)) Δx(j)/2, with S_0 = 0. A reference
/// never gives more than it got: hence max(…, 0).
///
/// A vanishing Δx would make f_pc any size, and a damper above twice a device's inertia over the
/// period turns the device round within a sample. Two limits, each of which leaves a rest of W for
/// later steps:
///   |f_pc| <= max_damping |Δx|/T,   |f_pc| <= max_effort                                  (pc-5)
///
/// What the law allows: from (pc-1), with the next step's Δx'
///   E(k+1) = E(k) + f_1(k) Δx + f_1(k) (Δx' - Δx) >= R(k) - |f_1(k)| |Δx' - Δx|           (pc-6)
/// R(k) = min(0, W + |f_pc Δx|) of the simple form is zero while no limit acts and the device
/// moved: the coming step is known only as far as the motion is even. The reference allows
///   E(k+1) >= E(k) + |f_pc(k) Δx| + f_2(k) Δx' - |f_pc(k)| |Δx' - Δx|                     (pc-7)
///
/// Holds for an ideal drive, a position sensor, no delay and a converter that changes nothing (its
/// limit and quantum come behind the controller); otherwise (pc-1) is an estimate. A run that
/// starts inside a wall starts with the wall's energy, which the simple observer does not know.
/// Source: Hannaford and Ryu 2002; Ryu et al. 2004, 2005; max(…, 0), max_damping, (pc-6) and (pc-7)
/// derived.
struct PassivityControl {
  enum class Observer { simple, reference };
  Observer observer = Observer::simple;
  std::optional<double> max_damping = {};  ///< [N.s/m, N.m.s/rad]; above 0
  std::optional<double> max_effort = {};   ///< [N, N.m]; above 0
};

/// The wall whose energy is a reference in closed form.
struct ReferenceWall {
  double stiffness = 0, damping = 0;
  bool unilateral = false;
  bool no_pull = false;  ///< the spring relaxes against its own damper instead of pulling
};

/// The running control. `step` allocates nothing.
class RunningPassivityControl {
 public:
  /// `wall`: of the wrapped law, if it is one. Throws bad_input for a limit that is not positive.
  RunningPassivityControl(const PassivityControl& control, const std::optional<ReferenceWall>& wall,
                          double period);

  /// The command for the position y when the wrapped controller asks for `command`.
  double step(double y, double command);

  double observed_energy() const { return observed_; }  ///< E(k) [J]
  double effort() const { return added_; }              ///< f_pc(k) [N, N.m]

  void append_signal_names(std::vector<std::string>& names) const;
  double* write_signals(double* value) const;

 private:
  void follow_reference(double y, double moved, double wanted);
  double find_effort(double shortfall, double moved) const;

  PassivityControl control_;
  std::optional<ReferenceWall> wall_;
  double period_;
  double observed_ = 0;   // E
  double reference_ = 0;  // S + D, or the trapezoids
  double stored_ = 0;     // S of the wall
  double start_ = 0;      // S_0
  double effort_ = 0;     // f_1
  double wanted_ = 0;     // f_2
  double added_ = 0;      // f_pc
  double last_ = 0;
  bool started_ = false;
};

}  // namespace gyrator
