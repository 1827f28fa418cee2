#include "gyrator/studies/time_map.hpp"

#include "gyrator/core/interrupt.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/port_response.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"
#include "gyrator/studies/parallel.hpp"
#include "gyrator/studies/progress.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr double hit_velocity_rotary = 5;    // rad/s
constexpr double hit_velocity_linear = 0.2;  // m/s
constexpr double hit_width = 0.01;           // s
constexpr double fewest_samples = 30;
constexpr double most_samples = 2e6;  // 250 MB on each core
constexpr int bisections = 10;        // a thousandth of a cell

struct Cell {
  double damping = 0, stiffness = 0;
};

const char* name_of(MapGesture gesture) {
  switch (gesture) {
    case MapGesture::model:
      return "model";
    case MapGesture::hit:
      return "hit";
    case MapGesture::hold:
      break;
  }
  return "hold";
}

bool moves_anything(const Model& model) {
  return model.gesture || model.initial_position != 0 || model.initial_velocity != 0 ||
         model.external_effort != 0;
}

// All runs of one gesture.
class Runs {
 public:
  Runs(const Model& model, const Plant& plant, const TimeMapRequest& request, MapGesture gesture)
      : wall_(std::get<VirtualWall>(model.controller.law)),
        controller_(model.controller),
        plant_(plant),
        scene_{model.sensor, model.sampling, {}},
        request_(request) {
    SimulationOptions& o = scene_.options;
    o.duration = request.duration.value_or(model.duration);
    o.dac = model.dac;
    o.seed = model.seed;
    o.engine_options.ledger = false;
    o.engine = choose_engine(plant);
    o.initial_position = model.initial_position;
    o.initial_velocity = model.initial_velocity;
    o.external_effort = model.external_effort;
    o.gesture = model.gesture;
    if (gesture != MapGesture::model) add_gesture(model, gesture);
    obstacle_ = find_lane_obstacle(plant, controller_, scene_);
    if (!obstacle_.empty()) return;
    lane_plant_ = make_lane_plant(plant, model.sampling);
    const double period = model.sampling.period.to_double();
    VirtualWall damper = wall_;
    damper.stiffness = 0;
    damper.damping = 1;
    unit_damper_ = *find_lane_law(Controller(damper), period);
  }

  const std::string& obstacle() const { return obstacle_; }
  double hit_effort() const { return hit_effort_; }

  std::vector<Classification> classify(const std::vector<Cell>& cells, Progress* progress) const {
    if (obstacle_.empty()) return classify_in_lanes(cells, progress);
    std::vector<Classification> found(cells.size());
    run_parallel(cells.size(), request_.threads, [&](std::size_t i) {
      throw_if_interrupted("zwidth");
      Controller controller = controller_;
      auto& wall = std::get<VirtualWall>(controller.law);
      wall.stiffness = cells[i].stiffness;
      wall.damping = cells[i].damping;
      found[i] = simulate(plant_, scene_.sensor, controller, scene_.sampling, scene_.options)
                     .classification;
      if (progress) progress->advance();
    });
    return found;
  }

 private:
  void add_gesture(const Model& model, MapGesture gesture) {
    SimulationOptions& o = scene_.options;
    o.initial_position = 0;
    o.initial_velocity = 0;
    o.external_effort = 0;
    const double velocity =
        model.device.motion == Motion::rotary ? hit_velocity_rotary : hit_velocity_linear;
    const double inertia = PortModel(model.device).blocked().inertia;
    // Impulse 2 A w/pi (hit-1) = inertia times velocity.
    hit_effort_ = std::numbers::pi * inertia * velocity / (2 * hit_width);
    if (gesture == MapGesture::hit) {
      o.gesture = HandGesture{HitGesture{hit_effort_, hit_width}};
    } else {
      o.gesture = HandGesture{HoldGesture{hit_effort_ / 2, 0, hit_width}};
    }
  }

  std::vector<Classification> classify_in_lanes(const std::vector<Cell>& cells,
                                                Progress* progress) const {
    LaneOptions options;
    options.threads = request_.threads;
    if (progress) options.on_progress = [&](std::size_t done) { progress->advance(done); };
    return classify_lanes(
        scene_, cells.size(),
        [&](std::size_t i, LaneDesign& design) {
          if (!design.plant) design = {&lane_plant_, unit_damper_};
          // K + B V(z): output row and feedthrough are linear in both.
          DiscreteStateSpace& law = design.law.law;
          law.C = cells[i].damping * unit_damper_.law.C;
          law.D = cells[i].stiffness + cells[i].damping * unit_damper_.law.D;
        },
        options);
  }

  VirtualWall wall_;
  Controller controller_;
  const Plant& plant_;
  LaneScene scene_;
  const TimeMapRequest& request_;
  std::string obstacle_;
  LanePlant lane_plant_;
  LaneLaw unit_damper_;
  double hit_effort_ = 0;
};

// Of several gestures, the one that a user would complain of.
void keep_worse(Classification& worst, const Classification& other) {
  if (other.outcome > worst.outcome ||
      (other.outcome == worst.outcome && other.amplitude > worst.amplitude))
    worst = other;
}

class Map {
 public:
  Map(const Model& model, const TimeMapRequest& request)
      : model_(model),
        request_(request),
        plant_(build_moving_plant(build_device_network(model.device, model.held_by))) {
    gestures_ = request.gestures;
    if (gestures_.empty()) {
      gestures_ = moves_anything(model) ? std::vector{MapGesture::model}
                                        : std::vector{MapGesture::hit, MapGesture::hold};
    }
    for (const MapGesture gesture : gestures_) runs_.emplace_back(model, plant_, request, gesture);
    stiffness_ = request.stiffness.empty() ? choose_stiffness() : request.stiffness;
  }

  json make() {
    const std::size_t columns = request_.damping.size();
    const std::size_t rows = stiffness_.size();
    Progress progress("Z-width map", columns * rows * runs_.size(), request_.quiet);
    std::vector<Cell> cells;
    cells.reserve(columns * rows);
    for (const double K : stiffness_) {
      for (const double B : request_.damping) cells.push_back({B, K});
    }
    cells_ = classify(cells, &progress);
    find_border();
    json boundary{{"criterion", "time"},
                  {"damping", request_.damping},
                  {"max_stiffness", json::array()},
                  {"feasible", json::array()},
                  {"worst_frequency_hz", json::array()}};
    for (const Border& border : border_) {
      boundary["max_stiffness"].push_back(finite_or_null(border.stiffness));
      boundary["feasible"].push_back(border.stiffness > 0);
      boundary["worst_frequency_hz"].push_back(finite_or_null(border.frequency_hz));
    }
    boundary["map"] = make_cells();
    return boundary;
  }

 private:
  struct Border {
    double stiffness = std::numeric_limits<double>::infinity();  // of none: nothing fails
    double frequency_hz = std::numeric_limits<double>::quiet_NaN();
  };

  std::vector<Classification> classify(const std::vector<Cell>& cells, Progress* progress) const {
    std::vector<Classification> worst = runs_.front().classify(cells, progress);
    for (std::size_t i = 1; i < runs_.size(); ++i) {
      const auto more = runs_[i].classify(cells, progress);
      for (std::size_t j = 0; j < worst.size(); ++j) keep_worse(worst[j], more[j]);
    }
    return worst;
  }

  // Half as much again as the exact loop with this operator allows at its best.
  std::vector<double> choose_stiffness() const {
    StiffnessLimits limits(model_.device, model_.sampling, model_.sampled_controller(),
                           model_.held_by);
    double largest = 0;
    bool any_stable = false;
    const std::size_t stride = std::max<std::size_t>(1, request_.damping.size() / 16);
    for (std::size_t i = 0; i < request_.damping.size(); i += stride) {
      const StiffnessLimit limit = limits.find(Criterion::coupled, request_.damping[i]);
      any_stable = any_stable || limit.feasible;
      if (limit.feasible && std::isfinite(limit.stiffness))
        largest = std::max(largest, limit.stiffness);
    }
    if (!(largest > 0)) {
      throw Error(ErrorCode::bad_input, "--stiffness",
                  std::string(any_stable ? "no stiffness makes" : "every stiffness makes") +
                      " the loop with the model's operator unstable at these dampings: give the "
                      "range of the map, such as --stiffness 0..1");
    }
    std::vector<double> stiffness;
    for (int i = 0; i < request_.rows; ++i)
      stiffness.push_back(1.5 * largest * (i + 1) / request_.rows);
    return stiffness;
  }

  // The first change from a row that settles to one that does not, in each column.
  void find_border() {
    const std::size_t columns = request_.damping.size();
    border_.assign(columns, {});
    std::vector<Cell> low, high;
    std::vector<std::size_t> at;
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t i = 0; i < stiffness_.size(); ++i) {
        const Classification& cell = cells_[i * columns + j];
        if (cell.outcome == Outcome::settles) continue;
        at.push_back(j);
        low.push_back({request_.damping[j], i > 0 ? stiffness_[i - 1] : 0});
        high.push_back({request_.damping[j], stiffness_[i]});
        // None where it ran away before it could be told.
        if (cell.frequency_hz > 0) border_[j].frequency_hz = cell.frequency_hz;
        break;
      }
    }
    for (int i = 0; i < bisections && !at.empty(); ++i) {
      std::vector<Cell> middle;
      for (std::size_t j = 0; j < at.size(); ++j)
        middle.push_back({low[j].damping, (low[j].stiffness + high[j].stiffness) / 2});
      const auto found = classify(middle, nullptr);
      for (std::size_t j = 0; j < at.size(); ++j) {
        const bool settles = found[j].outcome == Outcome::settles;
        (settles ? low : high)[j] = middle[j];
        if (!settles && found[j].frequency_hz > 0)
          border_[at[j]].frequency_hz = found[j].frequency_hz;
      }
    }
    for (std::size_t j = 0; j < at.size(); ++j) border_[at[j]].stiffness = low[j].stiffness;
  }

  json make_cells() const {
    const std::size_t columns = request_.damping.size();
    json outcome = json::array();
    json amplitude = json::array();
    json frequency = json::array();
    for (std::size_t i = 0; i < stiffness_.size(); ++i) {
      json outcomes = json::array();
      json amplitudes = json::array();
      json frequencies = json::array();
      for (std::size_t j = 0; j < columns; ++j) {
        const Classification& c = cells_[i * columns + j];
        const bool cycles = c.outcome == Outcome::limit_cycle;
        outcomes.push_back(static_cast<int>(c.outcome));
        amplitudes.push_back(cycles ? json(c.amplitude) : json());
        frequencies.push_back(cycles ? json(c.frequency_hz) : json());
      }
      outcome.push_back(std::move(outcomes));
      amplitude.push_back(std::move(amplitudes));
      frequency.push_back(std::move(frequencies));
    }
    json gestures = json::array();
    for (std::size_t i = 0; i < gestures_.size(); ++i) {
      json gesture{{"kind", name_of(gestures_[i])}};
      if (gestures_[i] == MapGesture::hit) {
        gesture["effort"] = runs_[i].hit_effort();
        gesture["width_s"] = hit_width;
      } else if (gestures_[i] == MapGesture::hold) {
        gesture["effort"] = runs_[i].hit_effort() / 2;
        gesture["rise_s"] = hit_width;
      }
      gestures.push_back(std::move(gesture));
    }
    const Rational duration = request_.duration.value_or(model_.duration);
    const std::string& obstacle = runs_.front().obstacle();
    return {{"stiffness", stiffness_},
            {"outcome", std::move(outcome)},
            {"outcome_names", {"settles", "limit_cycle", "diverges"}},
            {"amplitude", std::move(amplitude)},
            {"frequency_hz", std::move(frequency)},
            {"gestures", std::move(gestures)},
            {"duration_s", duration.to_double()},
            {"samples", floor_divide(duration, model_.sampling.period)},
            {"computed_by", obstacle.empty() ? std::string("lanes") : "cell by cell: " + obstacle}};
  }

  const Model& model_;
  const TimeMapRequest& request_;
  Plant plant_;
  std::vector<MapGesture> gestures_;
  std::vector<Runs> runs_;
  std::vector<double> stiffness_;
  std::vector<Classification> cells_;
  std::vector<Border> border_;
};

void check_request(const Model& model, const TimeMapRequest& request) {
  if (!request.stiffness.empty() && request.stiffness.front() < 0) {
    throw Error(ErrorCode::bad_input, "--stiffness",
                fmt::format("{:g}: must be 0 or more", request.stiffness.front()));
  }
  const Rational duration = request.duration.value_or(model.duration);
  const double samples = duration.to_double() / model.sampling.period.to_double();
  if (samples >= fewest_samples && samples <= most_samples) return;
  throw Error(ErrorCode::bad_input,
              request.duration ? "--duration" : model.file + ": /simulation/duration",
              fmt::format("{:g} s are {:.3g} samples: must be {:g} to {:g}, to tell growth from "
                          "rest within memory",
                          duration.to_double(), samples, fewest_samples, most_samples));
}

}  // namespace

json make_time_boundary(const Model& model, const TimeMapRequest& request) {
  if (!std::holds_alternative<VirtualWall>(model.controller.law)) {
    throw Error(ErrorCode::bad_input, model.file + ": /controller/kind",
                "the map by time is that of a sampled wall: use virtual_wall");
  }
  check_request(model, request);
  naming_file(model, [&] { require_stable_device(model.device); });
  return Map(model, request).make();
}

}  // namespace gyrator
