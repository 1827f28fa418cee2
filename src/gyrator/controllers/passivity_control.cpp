#include "gyrator/controllers/passivity_control.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

void check_limit(const char* name, const std::optional<double>& limit) {
  if (!limit || *limit > 0) return;
  throw Error(ErrorCode::bad_input, fmt::format("controller/{}", name),
              fmt::format("{:g}: must be above 0", *limit));
}

double spring_energy(const ReferenceWall& wall, double y) {
  const double x = wall.unilateral ? std::max(y, 0.0) : y;
  return wall.stiffness * x * x / 2;
}

}  // namespace

RunningPassivityControl::RunningPassivityControl(const PassivityControl& control,
                                                 const std::optional<ReferenceWall>& wall,
                                                 double period)
    : control_(control), wall_(wall), period_(period) {
  check_limit("max_damping", control.max_damping);
  check_limit("max_effort", control.max_effort);
}

// S + D after the step by which the device came to y.
void RunningPassivityControl::follow_reference(double y, double moved, double wanted) {
  if (!wall_) {
    reference_ += (wanted_ + wanted) * moved / 2;
    wanted_ = wanted;
    return;
  }
  const ReferenceWall& wall = *wall_;
  const double stored = spring_energy(wall, y);
  const double velocity = moved / period_;
  const bool touches = !wall.unilateral || y > 0;
  const bool lets_go = wall.no_pull && wall.stiffness * y + wall.damping * velocity < 0;
  if (touches && !lets_go) reference_ += wall.damping * velocity * moved;  // D
  if (!(touches && lets_go)) reference_ += stored - stored_;               // S
  stored_ = stored;
}

double RunningPassivityControl::find_effort(double shortfall, double moved) const {
  if (!(shortfall < 0) || moved == 0) return 0;
  double limit = INFINITY;
  if (control_.max_damping) limit = *control_.max_damping * std::abs(moved) / period_;
  if (control_.max_effort) limit = std::min(limit, *control_.max_effort);
  return std::clamp(-shortfall / moved, -limit, limit);
}

double RunningPassivityControl::step(double y, double command) {
  const double wanted = -command;
  if (!started_) {
    last_ = y;
    wanted_ = wanted;
    if (wall_) start_ = reference_ = stored_ = spring_energy(*wall_, y);
    started_ = true;
  }
  const double moved = y - last_;
  last_ = y;
  observed_ += effort_ * moved;
  double shortfall = observed_ + wanted * moved;
  if (control_.observer == PassivityControl::Observer::reference) {
    follow_reference(y, moved, wanted);
    shortfall = observed_ + start_ - std::max(reference_, 0.0);
  }
  added_ = find_effort(shortfall, moved);
  effort_ = wanted + added_;
  return -effort_;
}

void RunningPassivityControl::append_signal_names(std::vector<std::string>& names) const {
  names.insert(names.end(), {"observed_energy", "passivity_effort"});
}

double* RunningPassivityControl::write_signals(double* value) const {
  *value++ = observed_;
  *value++ = added_;
  return value;
}

}  // namespace gyrator
