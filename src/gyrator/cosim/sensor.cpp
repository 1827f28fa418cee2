#include "gyrator/cosim/sensor.hpp"

#include <cmath>

namespace gyrator {

double round_to_multiple(double value, double quantum) {
  return quantum > 0 ? quantum * std::floor(value / quantum + 0.5) : value;
}

double RunningSensor::read(double position) {
  if (sensor_.noise > 0) position += sensor_.noise * noise_.normal();
  return round_to_multiple(position, sensor_.quantum) + sensor_.offset;
}

}  // namespace gyrator
