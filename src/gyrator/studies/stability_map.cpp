#include "gyrator/studies/stability_map.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/studies/progress.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr double oscillations = 60;  // in a run, of the wall's own
constexpr std::int64_t fewest_samples = 600;
constexpr std::int64_t most_samples = 200000;
constexpr double growth = 1.02;  // from third to third of a run

// The plane's scales, from the model.
struct Scales {
  double stiffness, period, quantum, delay_in_periods;
};

Scales find_scales(const Model& model) {
  const auto* wall = std::get_if<VirtualWall>(&model.controller.law);
  const auto refuse = [&](const char* place, const char* message) {
    throw Error(ErrorCode::bad_input, model.file + ": /" + place, message);
  };
  if (!wall) refuse("controller/kind", "the map is that of a sampled wall: use virtual_wall");
  if (!(wall->stiffness > 0)) refuse("controller/stiffness", "0: must be above 0 for the map");
  if (!(model.sensor.quantum > 0)) {
    refuse("sensor/quantum", "0: the map is that of a quantized position: give the encoder's step");
  }
  if (has_nonlinear_wrapper(model.controller)) {
    refuse("controller",
           "the map is that of the wall alone: leave passivity control and contact effects out");
  }
  if (model.gesture)
    refuse("simulation/gesture", "the map kicks the device itself: leave the gesture out");
  const double period = model.sampling.period.to_double();
  return {wall->stiffness, period, model.sensor.quantum, model.sampling.delay.to_double() / period};
}

Rational choose_duration(const Model& model, const Scales& scales, const Rational& asked) {
  if (asked > Rational(0)) {
    if (floor_divide(asked, model.sampling.period) >= fewest_samples) return asked;
    throw Error(ErrorCode::bad_input, "--duration",
                fmt::format("{:g} s: must be at least {} sample periods to tell rest from growth",
                            asked.to_double(), fewest_samples));
  }
  double inertia = model.device.mechanics.inertia;
  if (const auto& t = model.device.mechanics.transmission) inertia += t->load_inertia;
  const double oscillation = 2 * std::numbers::pi * std::sqrt(inertia / scales.stiffness);
  const auto samples = static_cast<std::int64_t>(oscillations * oscillation / scales.period);
  return model.sampling.period * Rational(std::clamp(samples, fewest_samples, most_samples));
}

enum class After { rests, moves_on, grows };

// Largest absolute value between two parts of a column, given in thirtieths of it.
double peak(const std::vector<double>& column, std::size_t from, std::size_t to) {
  double largest = 0;
  for (std::size_t i = column.size() * from / 30; i < column.size() * to / 30; ++i)
    largest = std::max(largest, std::abs(column[i]));
  return largest;
}

// With friction a device that rests sticks, and its velocity is zero exactly. What grows does so
// from third to third; a limit cycle that is reached from below has stopped growing by the last.
After judge(const TimeRun& run) {
  if (run.stopped_early) return After::grows;
  const auto& velocity = run.trace.column("velocity");
  if (peak(velocity, 27, 30) == 0) return After::rests;
  const double last = peak(velocity, 20, 30);
  const bool grows =
      last > growth * peak(velocity, 10, 20) && last > growth * peak(velocity, 0, 10);
  return grows ? After::grows : After::moves_on;
}

// One point of the plane, ready to be kicked.
class Point {
 public:
  Point(const Model& model, const Scales& scales, double beta, double sigma)
      : model_(model), scales_(scales), controller_(keep_in_contact(model.controller)) {
    Device device = model.device;
    device.mechanics.damping = beta * scales.stiffness * scales.period;
    device.mechanics.stiction.reset();
    device.mechanics.coulomb_friction = sigma * scales.stiffness * scales.quantum;
    plant_ = build_moving_plant(build_device_network(device, model.held_by));
  }

  After kick(double velocity, const Rational& duration) const {
    SimulationOptions options;
    options.duration = duration;
    // The edge between the quanta of zero and one: halves are rounded up.
    options.initial_position = scales_.quantum / 2 - model_.sensor.offset;
    options.initial_velocity = velocity * scales_.quantum / scales_.period;
    options.external_effort = scales_.stiffness * (scales_.quantum / 2 + model_.sensor.offset);
    options.dac = model_.dac;
    options.seed = model_.seed;
    options.engine = choose_engine(plant_);
    options.engine_options.ledger = false;
    return judge(simulate(plant_, model_.sensor, controller_, model_.sampling, options));
  }

 private:
  const Model& model_;
  const Scales& scales_;
  Controller controller_;
  Plant plant_;
};

StabilityRegion combine(After small, After large) {
  if (large == After::grows) {
    return small == After::rests ? StabilityRegion::locally_stable : StabilityRegion::unstable;
  }
  const bool rests = small == After::rests && large == After::rests;
  return rests ? StabilityRegion::passive : StabilityRegion::limit_cycle;
}

}  // namespace

std::string_view name_of(StabilityRegion region) {
  switch (region) {
    case StabilityRegion::passive:
      return "passive";
    case StabilityRegion::locally_stable:
      return "locally_stable";
    case StabilityRegion::limit_cycle:
      return "limit_cycle";
    case StabilityRegion::unstable:
      break;
  }
  return "unstable";
}

StabilityRegion judge_stability_region(double beta, double sigma, double delay_in_periods,
                                       double largest_velocity) {
  const double enough = 0.5 + delay_in_periods;
  if (sigma >= 0.5) {
    if (beta >= enough) return StabilityRegion::passive;
    return sigma >= 0.5 + largest_velocity * (enough - beta) ? StabilityRegion::locally_stable
                                                             : StabilityRegion::unstable;
  }
  return beta >= enough ? StabilityRegion::limit_cycle : StabilityRegion::unstable;
}

json make_stability_map_result(const Model& model, const StabilityMapRequest& request) {
  const Scales scales = find_scales(model);
  const Rational duration = choose_duration(model, scales, request.duration);
  Progress progress("stability map", request.beta.size() * request.sigma.size(), request.quiet);
  json simulated = json::array();
  json analytic = json::array();
  int unsafe = 0;  // points that should rest and do not
  int stricter = 0;
  for (const double sigma : request.sigma) {
    json simulated_row = json::array();
    json analytic_row = json::array();
    for (const double beta : request.beta) {
      throw_if_interrupted("stability-map");
      const Point point(model, scales, beta, sigma);
      const auto found = combine(point.kick(request.small_velocity, duration),
                                 point.kick(request.large_velocity, duration));
      const auto expected =
          judge_stability_region(beta, sigma, scales.delay_in_periods, request.large_velocity);
      if (expected == StabilityRegion::passive && found != expected) ++unsafe;
      if (expected != StabilityRegion::passive && found == StabilityRegion::passive) ++stricter;
      simulated_row.push_back(name_of(found));
      analytic_row.push_back(name_of(expected));
      progress.advance();
    }
    simulated.push_back(std::move(simulated_row));
    analytic.push_back(std::move(analytic_row));
  }
  json result = start_result("stability-map", model);
  result["beta"] = request.beta;
  result["sigma"] = request.sigma;
  result["region"] = std::move(simulated);
  result["analytic_region"] = std::move(analytic);
  result["stiffness"] = scales.stiffness;
  result["quantum"] = scales.quantum;
  result["period_s"] = scales.period;
  result["delay_in_periods"] = scales.delay_in_periods;
  result["small_velocity"] = request.small_velocity;
  result["large_velocity"] = request.large_velocity;
  result["duration_s"] = duration.to_double();
  result["passive_points_that_do_not_rest"] = unsafe;
  result["other_points_that_rest"] = stricter;
  return result;
}

}  // namespace gyrator
