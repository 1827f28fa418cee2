#include "gyrator/twin/winding_heat.hpp"

#include <cmath>

namespace gyrator {

WindingHeat::WindingHeat(const Motor& motor, const WindingThermal& thermal, double ambient,
                         double rise, double tick)
    : cold_(motor.resistance),
      alpha_(motor.temperature_coefficient),
      ambient_(ambient),
      rise_(rise),
      time_constant_(thermal.resistance * thermal.capacity),
      keeps_(std::exp(-tick / time_constant_)),
      by_heat_(-thermal.resistance * std::expm1(-tick / time_constant_)) {}

void WindingHeat::warm(double before, double after) {
  const double mean_square = (before * before + before * after + after * after) / 3;
  rise_ = keeps_ * rise_ + by_heat_ * resistance() * mean_square;
}

void WindingHeat::cool(double seconds) {
  rise_ *= std::exp(-seconds / time_constant_);
}

}  // namespace gyrator
