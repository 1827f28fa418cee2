#include "gyrator/studies/twin_model.hpp"

namespace gyrator {

TwinDevice make_twin_device(const Model& model) {
  TwinDevice twin;
  twin.device = model.device;
  twin.delay = model.sampling.delay.to_double();
  twin.position_quantum = model.sensor.quantum;
  twin.noise.position = model.sensor.noise;
  twin.seed = model.seed;
  if (const auto& motor = model.device.drive.motor) {
    if (motor->thermal) twin.thermal = *motor->thermal;
    twin.winding_rise = motor->temperature_rise;
  }
  if (model.device.motion == Motion::linear) twin.velocity_limit = 10;
  return twin;
}

}  // namespace gyrator
