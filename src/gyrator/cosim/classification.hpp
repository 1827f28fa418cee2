#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace gyrator {

enum class Outcome { settles, limit_cycle, diverges };

std::string_view name_of(Outcome outcome);

/// How a run ends, judged by the velocity at its end (so that a device that drifts away at rest
/// counts as settled). The velocity is cut into cycles at its upward crossings of its middle value;
/// with the swing s of a cycle, half its peak-to-peak velocity,
///   growth = exp(g h), g the slope of the straight line through ln s over t,        (cls-1)
/// over the cycles of the run's last third, h a sixth of the run. A growth that does not stand out
/// from the scatter of the swings by three standard errors is none: a motion kept up by noise or by
/// a restless hand is a sustained one. Where the third holds fewer than two cycles, the last two
/// thirds are taken, then the whole run. Without two cycles anywhere the motion does not oscillate:
/// its growth is the ratio of its sizes in the last two sixths if it has grown from sixth to sixth
/// without slowing down; else, where the last third still has half of the largest swing (one bounce
/// that takes most of the run), the root of what the swing has multiplied by from the first third
/// to the last; else zero. Diverges above `growth_limit`, or where the run was stopped; settles
/// below 1/`growth_limit`, or where the last swing is below `rest_fraction` of the run's largest;
/// else a sustained oscillation.
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
Classification classify(const std::vector<double>& position, const std::vector<double>& velocity,
                        double period, bool stopped_early,
                        const ClassificationOptions& options = {});

}  // namespace gyrator
