#pragma once

#include "gyrator/circuits/state_space.hpp"
#include "gyrator/controllers/discrete_state_space.hpp"
#include "gyrator/verification/slope_form.hpp"

#include <complex>

namespace gyrator {

/// A certificate's device: with its port's velocity v imposed and the command u,
///   dx/dt = A x + B [u; v],  [f - port_inertia dv/dt; v_s] = C x + D [u; v]            (held-1)
/// f the effort that the operator gives, v_s the rate of what is sampled. One output where v_s = v.
struct HeldDevice {
  StateSpace system;
  double port_inertia = 0;  ///< [kg, kg.m^2]

  bool collocated() const { return system.C.rows() == 1; }
};

/// f = Z v - A u, v_s = S v + M u at one frequency (port-1 of docs/passivity.md), by a dense
/// solve in extended precision.
struct HeldResponse {
  std::complex<long double> impedance, actuation, sensor_path, blocked;
};
HeldResponse compute_held_response(const HeldDevice& device, long double omega);

/// What the disk needs of the device over an interval of frequencies.
struct HeldForms {
  SlopeForm damping;  ///< Re Z
  SlopeForm path;     ///< S A
  SlopeForm blocked;  ///< M
};

/// The same over a band of high frequencies, as ranges.
struct HeldBand {
  Disc center;         ///< M + S A/(2 Re Z)
  double lowest = 0;   ///< |S A|/(2 Re Z)
  double highest = 0;  ///< infinite where Re Z > 0 could not be shown
};

/// Encloses a device's response over intervals. With R = (s0 I - A)^-1 and s = s0 + jt,
///   x = x0 - j t R x0 + e,   |e| <= t^2 |R| (I - |t| |R|)^-1 |R x0|                    (held-2)
/// entry by entry, wherever the inverse has no negative entry (Neumann's series); no modes.
class HeldEnclosure {
 public:
  explicit HeldEnclosure(const HeldDevice& device);

  /// Over |w - omega| <= reach, of either sign. At zero frequency a spring to ground at the port,
  /// which has no real part, is left out.
  HeldForms at(double omega, double reach) const;

  /// Over low <= 1/w <= high [s/rad], low = 0 for all frequencies above 1/high:
  ///   G(j/p) = D + p C (jI - pA)^-1 B,  Re G = D - p^2 C A (I + p^2 A^2)^-1 B         (held-3)
  /// with as many powers of p taken out of Re Z and S A as vanish there (coefficients below 1e-9 of
  /// what they are made of count as zero).
  HeldBand at_inverse(double low, double high) const;

  /// Size of the fastest pole [rad/s].
  double fastest() const;

 private:
  struct Entry {
    Eigen::RowVectorXd row;
    Eigen::VectorXd column;
    double direct = 0;
  };
  SlopeForm leading_form(const Entry& entry, const Eigen::MatrixXcd& middle, double p, double reach,
                         int& order) const;
  SlopeForm damping_form(double low, double high, int& order) const;

  bool collocated_;
  Eigen::MatrixXd A_, C_;
  Eigen::MatrixXd B_, D_;
  Eigen::MatrixXd shifted_A_, shifted_B_;  // without the spring to ground
};

/// H(z) at z = e^(j(omega + t)T), |t| <= reach, in the same way.
SlopeForm enclose_law(const DiscreteStateSpace& law, double period, double omega, double reach);

/// H(e^(j omega T)) in extended precision.
std::complex<long double> compute_law(const DiscreteStateSpace& law, long double angle);

}  // namespace gyrator
