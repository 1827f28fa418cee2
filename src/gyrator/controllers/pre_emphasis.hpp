#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"

namespace gyrator {

/// Output stage that undoes the drive's lag: the command passes F(z), the discrete inverse of the
/// actuation path A within a band, before it is held.
struct PreEmphasis {
  DiscreteStateSpace filter = make_gain(1);  ///< F(z)
};

/// The running filter. `step` allocates nothing.
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
