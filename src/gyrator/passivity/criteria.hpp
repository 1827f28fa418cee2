#pragma once

#include "gyrator/passivity/verdict.hpp"

namespace gyrator {

/// What a device is like against the assumptions of the textbook criteria.
struct Assumptions {
  bool constant_damping = true;        ///< Re Z the same at all frequencies
  bool non_decreasing_damping = true;  ///< Re Z never falls as frequency rises, to infinity
  bool ideal_drive = true;             ///< A = 1 up to far beyond Nyquist
  bool collocated = true;              ///< the sensor sees the port
  bool filtered = false;               ///< … through an analog low-pass
  bool held = false;                   ///< the wall is an analog loop of the device
  bool reads_wave = false;             ///< the controller samples no motion at all
  bool predicts = false;               ///< the wall is rendered where the device will be
  bool no_delay = true;
  bool whole_delay = true;     ///< a whole number of periods
  double falling_from_hz = 0;  ///< where Re Z starts to fall
  double lag_s = 0;            ///< lag of A at low frequency, -d(arg A)/dw
};
Assumptions test_assumptions(const Device& device, const Sampling& sampling, PortModel& model);

/// The law that the textbook judges: H of a wall from the position, also where the same wall lies
/// behind a wave line.
DiscreteStateSpace make_textbook_law(const Controller& controller, double period);

/// spring_damper [8.4], frequency_dependent [8.46] and quantized_coulomb [8.5] for the model.
std::vector<CriterionResult> judge_textbook(const PassivityModel& model, Assumptions assumptions,
                                            StiffnessLimits& limits);

}  // namespace gyrator
