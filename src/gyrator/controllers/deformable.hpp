#pragma once

#include "gyrator/controllers/slow_clock.hpp"
#include "gyrator/controllers/virtual_chain.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// A deformable object with one degree of freedom, the position s of its surface:
///   m_e s'' + c_e s' + k_e (s - x_0) = F_c                                       (deformable-1)
/// It is touched from below: by what lies at a position above s.
struct DeformableObject {
  double inertia = 1;      ///< m_e [kg, kg.m^2]
  SpringDamper to_ground;  ///< k_e, c_e
  double position = 0;     ///< x_0, of the surface at rest [m, rad]
};

/// What the three renderings share. The contact's spring and damper act between what touches and
/// the surface; unilateral they act in penetration only, and only push.
struct DeformableScene {
  DeformableObject object;
  SpringDamper contact;  ///< k_c, c_c
  bool unilateral = true;
  Integration integration = Integration::semi_implicit;
  int substeps = 1;
  SlowUpdate update;
};

/// Direct rendering: the sampled position y of the device is the tool. At each update
///   F_c = k_c (y - s) + c_c (v - s')                                             (deformable-2)
/// moves the object and is sent to the device, which holds it; v is the difference over the
/// update's period. Source: Kim and Lee 2017, fig. 1 (there with a passivity controller around it).
struct DirectRendering {
  DeformableScene scene;
};

/// Proxy: a virtual tool (mass m_t) tied to the sampled position by the coupling touches the
/// object; the effort of the coupling is sent to the device, which holds it,
///   F = k_vc (y - p) + c_vc (v - p'),   m_t p'' = F - F_c,   F_c of tool and surface
///   (deformable-3)
/// Source: Kim and Lee 2017, fig. 2.
struct ProxyRendering {
  DeformableScene scene;
  double tool_inertia = 1;  ///< m_t [kg, kg.m^2]
  SpringDamper coupling;    ///< k_vc, c_vc
};

/// Equivalent impedance: the update conveys not an effort but the object's impedance (m_e, c_e,
/// k_e) and its surface. The fast loop moves a copy of the object at its own rate, with
/// (deformable-2) between device and copy; the slow object follows, pushed by the mean effort since
/// its last tick. Out of contact the copy takes the conveyed surface unless that would put the
/// device inside. The fast loop knows the object at rest from the start on.
///
/// With an inertia of its own the copy cannot be moved by the device itself (that would feed back
/// its measured acceleration): the contact's spring ties them, and what is felt is
/// Z_c Z_e/(Z_c + Z_e), the nearer to Z_e the stiffer the contact.
/// Source: Kim and Lee 2017, fig. 3, which has the ideal Z_eq = Z_e.
struct EquivalentImpedance {
  DeformableScene scene;
};

/// H(z) from position to opposing effort, in contact, about the surface at rest. Direct and proxy
/// throw bad_input unless computed in the loop; the equivalent impedance has one at any update.
DiscreteStateSpace make_deformable_law(const DirectRendering& law, double period);
DiscreteStateSpace make_deformable_law(const ProxyRendering& law, double period);
DiscreteStateSpace make_deformable_law(const EquivalentImpedance& law, double period);

/// Direct rendering and proxy while they run. `step` allocates nothing.
class RunningHeldRendering {
 public:
  RunningHeldRendering(const DirectRendering& law, double period);
  RunningHeldRendering(const ProxyRendering& law, double period);

  /// Command for the sampled position y.
  double step(double y);

  double surface_position() const;  ///< of the object [m, rad]

  void append_signal_names(std::vector<std::string>& names) const;
  double* write_signals(double* value) const;

 private:
  RunningHeldRendering(const ChainModel& chain, const DeformableScene& scene, double period);

  bool has_tool_;
  double rest_;
  SlowLink<double> link_;  // the effort
  VirtualChain chain_;
  double last_ = 0;
  bool started_ = false;
};

/// The equivalent impedance while it runs. `step` allocates nothing.
class RunningEquivalentImpedance {
 public:
  RunningEquivalentImpedance(const EquivalentImpedance& law, double period);

  /// Command for the sampled position y.
  double step(double y);

  double surface_position() const { return object_.state().position[0]; }  ///< simulated [m, rad]
  double felt_surface() const { return copy_.state().position[0]; }        ///< of the copy [m, rad]

  void append_signal_names(std::vector<std::string>& names) const {
    names.insert(names.end(), {"surface_position", "felt_surface_position"});
  }
  double* write_signals(double* value) const {
    value[0] = surface_position();
    value[1] = felt_surface();
    return value + 2;
  }

 private:
  struct Conveyed {
    DeformableObject impedance;
    double surface = 0, surface_velocity = 0;
  };

  double period_;
  DeformableObject described_;  // what the simulation holds true now
  SlowLink<Conveyed> link_;
  VirtualChain object_, copy_;
  double last_ = 0, pushed_ = 0;
  long ticks_ = 0;
  bool unilateral_, touching_ = false, started_ = false;
};

}  // namespace gyrator
