#include "gyrator/twin/winding_heat.hpp"

#include <cmath>

namespace gyrator {

WindingHeat::WindingHeat(const Motor& motor, const WindingThermal& thermal, double ambient,
                         double rise, double tick)
    : cold_(motor.resistance),
      alpha_(motor.temperature_coefficient),
      ambient_(ambient),
      rise_(rise),
      keeps_(std::exp(-tick / (thermal.resistance * thermal.capacity))),
      by_heat_(-thermal.resistance * std::expm1(-tick / (thermal.resistance * thermal.capacity))) {}

void WindingHeat::warm(double before, double after) {
  const double mean_square = (before * before + before * after + after * after) / 3;
  rise_ = keeps_ * rise_ + by_heat_ * resistance() * mean_square;
}

}  // namespace gyrator
