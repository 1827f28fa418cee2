#pragma once

#include "gyrator/synthesis/design_spec.hpp"

#include <span>

namespace gyrator {

/// The controller of a design: the model's wall with the estimator and the output stage that the
/// option asks for.
///   velocity   the model's low-pass estimator with the sought cut-off, filtered_difference where
///              it has another one
///   F          pre-emphasis (emph-1) by the roots of this very device
class DigitalStage {
 public:
  DigitalStage(const Model& model, const DesignOption& option);

  /// `values` of the option's, in their order; `device` as the stage is set up for.
  Controller make(const Device& device, std::span<const double> values) const;

 private:
  Controller wall_;
  double period_;
  bool pre_emphasis_, velocity_filter_;
  double band_;  // [rad/s]
};

/// The estimator with another cut-off [Hz]; a filtered difference in place of one without.
VelocityEstimator with_cutoff(const VelocityEstimator& estimator, double cutoff_hz);

/// Largest |F(e^(jwT))| of the controller's output stage over 0 < w <= pi/T, at 64 frequencies: by
/// so much noise and steps of the command are raised at most.
double find_emphasis_gain(const Controller& controller);

}  // namespace gyrator
