#pragma once

#include <string_view>
#include <vector>

namespace gyrator {

enum class Outcome { settles, limit_cycle, diverges };

std::string_view name_of(Outcome outcome);

/// How a run ends, judged by the velocity in its last third (so that a device that drifts away at
/// rest counts as settled):
///   growth = swing in the second half of that third / swing in its first half     (cls-1)
/// where the swing is half the peak-to-peak velocity. Diverges above `growth_limit`, or where the
/// run was stopped; settles below 1/`growth_limit`, or where the swing is below `rest_fraction` of
/// the run's largest; else a sustained oscillation.
struct ClassificationOptions {
  double growth_limit = 1.02;
  double rest_fraction = 1e-4;
};

struct Classification {
  Outcome outcome = Outcome::settles;
  double growth = 0;
  double amplitude = 0;     ///< half peak-to-peak position in the last third [m, rad]
  double frequency_hz = 0;  ///< from velocity sign changes in the last third; 0 without any
};

/// `position` and `velocity` at equal spacing `period` [s]; `stopped_early` when the run was
/// stopped because it had grown out of all bounds.
Classification classify(const std::vector<double>& position, const std::vector<double>& velocity, double period,
                        bool stopped_early, const ClassificationOptions& options = {});

}  // namespace gyrator
