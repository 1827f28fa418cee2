#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"

#include <complex>
#include <vector>

namespace gyrator {

/// Output stage that undoes the drive's lag: before it is held, the command passes F(z), the
/// discrete inverse of the actuation path A_0 = prod (1 - s/z_j) / prod (1 - s/p_i) within a band,
///   F(z) = (1 + τ/T - τ/(T z)) · prod_i (1 - a_i/z)/(1 - a_i) · prod_j (1 - c_j)/(1 - c_j/z),
///   a_i = e^(p_i T), c_j = e^(z_j T), over poles p_i and zeros z_j below the band's edge, (emph-1)
///   τ = sum (-1/p_i) + sum 1/z_j over those beyond Nyquist
/// with F(1) = 1. What is too fast for the samples is thus undone to first order, by its lag τ;
/// roots between the edge and Nyquist are left as they are, and so is a slow zero in the right
/// half-plane, which has no stable inverse. F raises what changes fast, noise and the steps of the
/// encoder included, by up to F(-1).
struct PreEmphasis {
  DiscreteStateSpace filter = make_gain(1);  ///< F(z)
};

/// `poles` and `zeros` of A_0 and the edge `band` [rad/s], at most pi/period; `period` in s. Throws
/// bad_input (place controller/pre_emphasis/band) for an edge that is not above 0 or beyond
/// Nyquist.
PreEmphasis make_pre_emphasis(const std::vector<std::complex<double>>& poles,
                              const std::vector<std::complex<double>>& zeros, double band,
                              double period);

/// The running filter, which starts from a command that has always been zero. `step` allocates
/// nothing.
class RunningPreEmphasis {
 public:
  explicit RunningPreEmphasis(const PreEmphasis& stage)
      : filter_(stage.filter), state_(stage.filter) {}

  double step(double /*y*/, double command) { return state_.step(filter_, command); }

 private:
  DiscreteStateSpace filter_;
  DiscreteLawState state_;
};

}  // namespace gyrator
