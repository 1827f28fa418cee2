#pragma once

#include "gyrator/robustness/box_descriptor.hpp"
#include "gyrator/robustness/divided_model.hpp"

#include <vector>

namespace gyrator {

/// (port-1) over a band of frequencies and a box of parts, as far as the aliased disk needs it.
struct BoxPort {
  BoxModel damping;  ///< Re Z
  BoxModel path;     ///< S A
  BoxModel blocked;  ///< M
};
struct DividedPort {
  BoxModel damping;
  DividedModel path, blocked;
};

/// The device with its port's velocity imposed, over a box of its parts. With the terms of (box-3),
///   M = sE - A = M_0 + sum_t theta_t u_t v_t^T,
/// the unknowns x follow from the rows but the port's, whose own says the effort f_h. Every load
/// has the form b_0 - sum_t beta_t u_t, so that
///   x - x_0 = -sum_t gamma_t R u_t,   gamma_t = d beta_t + theta_t v_t^T x,   R = M_0^-1   (box-6)
/// With W = V^T R U and P = |theta| |W|, where (I - P) w = 1 has a solution w > 0, gamma is within
///   rho = (I - P)^-1 (what d beta has beyond the first order + |theta| |v^T(x_1 - x_0)|)   (box-7)
/// of its first order, x_1 the first order of x; and M is regular in all of the band and the box.
/// What an element's two terminals have in common does not matter: v_t^T x is what lies across it.
class BoxPortModel {
 public:
  /// Throws bad_input where the device has no steady state with its port held.
  explicit BoxPortModel(BoxDescriptor descriptor);

  BoxPort expand(const Band& band) const;
  /// With divided differences at zero frequency.
  DividedPort expand_divided(const Band& band) const;

  /// Of P in (box-7), its spectral radius: from 1 on the box is too wide for the band.
  double find_width(const Band& band) const;

  bool collocated() const { return d_.collocated; }
  std::size_t variables() const { return d_.parts + 1; }

 private:
  class Solver;
  struct Solution;
  std::vector<BoxModel> store(const Solution& x) const;
  BoxModel storage_effort(const Solution& x) const;
  BoxModel rest_effort(const Solution& x) const;
  BoxModel sense(const Solution& x) const;
  BoxModel coefficient(std::size_t term) const;

  BoxDescriptor d_;
  std::vector<BoxModel> command_load_, motion_load_;            // E x at zero frequency, per term
  std::vector<BoxModel> command_next_load_, motion_next_load_;  // E q1 of x
  BoxModel effort_c0_, effort_c1_, sensor_c0_, sensor_c1_, blocked_c0_, blocked_c1_;
};

}  // namespace gyrator
