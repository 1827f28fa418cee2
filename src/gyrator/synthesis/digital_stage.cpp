#include "gyrator/synthesis/digital_stage.hpp"

#include "gyrator/mechanics/actuation_roots.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace gyrator {
namespace {

using nlohmann::json;

// The edge that the model's own stage has, else Nyquist.
double find_band(const Model& model, double period) {
  const double nyquist = std::numbers::pi / period;
  const json stage = model.source.value("/controller/pre_emphasis"_json_pointer, json::object());
  if (!stage.is_object() || !stage.contains("band")) return nyquist;
  const json& band = stage["band"];
  return 2 * std::numbers::pi *
         (band.is_number() ? band.get<double>()
                           : parse_value(band.get<std::string>(), dimension::frequency));
}

}  // namespace

VelocityEstimator with_cutoff(const VelocityEstimator& estimator, double cutoff_hz) {
  if (const auto* butterworth = std::get_if<ButterworthEstimator>(&estimator))
    return ButterworthEstimator{butterworth->order, cutoff_hz};
  return FilteredDifferenceEstimator{cutoff_hz};
}

DigitalStage::DigitalStage(const Model& model, const DesignOption& option)
    : wall_(model.sampled_controller()),
      period_(model.sampling.period.to_double()),
      pre_emphasis_(option.pre_emphasis),
      velocity_filter_(option.velocity_filter),
      band_(find_band(model, period_)) {
  wall_.wrappers.clear();  // a stage of the bare device would undo another lag
}

Controller DigitalStage::make(const Device& device, std::span<const double> values) const {
  Controller controller = wall_;
  if (velocity_filter_) {
    auto& wall = std::get<VirtualWall>(controller.law);
    wall.velocity = with_cutoff(wall.velocity, values.back());
  }
  if (pre_emphasis_) {
    const ActuationRoots roots = find_actuation_roots(device);
    controller.wrappers.emplace_back(make_pre_emphasis(roots.poles, roots.zeros, band_, period_));
  }
  return controller;
}

double find_emphasis_gain(const Controller& controller) {
  constexpr int frequencies = 64;
  if (controller.wrappers.empty()) return 1;
  const DiscreteStateSpace stage = make_output_law(controller);
  double highest = 1;
  for (int i = 1; i <= frequencies; ++i) {
    const auto z = std::polar(1.0, std::numbers::pi * i / frequencies);
    highest = std::max(highest, std::abs(stage.response(z)));
  }
  return highest;
}

}  // namespace gyrator
