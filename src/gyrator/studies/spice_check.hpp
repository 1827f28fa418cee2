#pragma once

#include "gyrator/studies/spice_deck.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// How far ngspice is off in one quantity.
struct SpiceDeviation {
  std::string quantity;    ///< "impedance", "actuation", "position", "velocity", "current"
  double worst = 0;        ///< relative: to the magnitude at that frequency, or to the largest
  double at = 0;           ///< where: frequency [Hz] or time [s]
  double tolerance = 0;    ///< 1e-6 over frequency, 1e-4 over time
  bool over_time = false;  ///< `at` is a time

  bool agrees() const { return worst <= tolerance; }
};

/// Runs ngspice on the deck and compares: Z and A with those straight from the network's equations
/// at every frequency, the motion with the run of the engine that `simulate` takes at every sample
/// instant. Errors as those of run_ngspice.
std::vector<SpiceDeviation> check_spice_deck(const Model& model, const SpiceRequest& request,
                                             const SpiceDeck& deck);

}  // namespace gyrator
