#pragma once

#include "gyrator/two_port/sampled_port.hpp"
#include "gyrator/two_port/two_port.hpp"

#include <string_view>

namespace gyrator {

/// Where the effort of a coupling between two devices is computed.
enum class CouplingPlace {
  both_ends,  ///< at each end from its own motion and the other's late one
  slave       ///< at the slave, and sent back to the master
};
std::string_view name_of(CouplingPlace place);

/// Two devices joined by a spring and damper that is computed at their common period.
struct DeviceCoupling {
  SpringDamper law;        ///< K [N/m, N.m/rad], B [N.s/m, N.m.s/rad]
  double delay_there = 0;  ///< of what goes from master to slave [s]
  double delay_back = 0;   ///< of what comes back [s]
  CouplingPlace place = CouplingPlace::both_ends;
};

/// The two-port between the operators of two coupled devices, from both ports' impedance matrix
///   z = diag(Z) + diag(A P) (1 + Γ diag(V M P))^-1 Γ diag(V S)                     (coupled-1)
///   Γ = C [1, -d_2; -d_1, 1] at both ends,   C [d_1 d_2, -d_2; -d_1, 1] at the slave,
///   C = B + K/D,   d_i = e^(-jw t_i)
/// (sampled-1) at each end; t_1 there, t_2 back, beyond each path's own delay. In continuous time,
/// for two equal devices m, b, coupled at both ends with t_1 = t_2 = t, Llewellyn's third condition
/// is
///   b + B >= |B cos wt - (K/w) sin wt|     at every frequency,                     (coupled-2)
/// hence K t <= b + 2 B at low frequency: an undelayed coupling is absolutely stable.
class CoupledDevices {
 public:
  /// Paths of equal period and step (bad_input, at sampling/period, otherwise), or both continuous.
  CoupledDevices(const Device& master, const ComputedPath& master_path, const Device& slave,
                 const ComputedPath& slave_path, const DeviceCoupling& coupling);

  ImpedanceMatrix impedance_at(double omega);
  HybridMatrix at(double omega) { return impedance_at(omega).to_hybrid(); }

  /// Up to Nyquist; in continuous time up to `highest` [rad/s].
  TwoPortVerdict judge(double highest = 0);
  std::vector<double> make_grid(double highest = 0) const;

 private:
  PortModel master_, slave_;
  ComputedPath master_path_, slave_path_;
  DeviceCoupling coupling_;
};

}  // namespace gyrator
