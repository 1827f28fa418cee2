#pragma once

#include "gyrator/studies/model_file.hpp"
#include "gyrator/twin/twin_device.hpp"

namespace gyrator {

/// What `gyrator twin` takes of a model: motor with its thermal values, mechanics, amplifier,
/// damping, the sensor's quantum, noise and place, the computation's delay and the seed.
/// Controller, operator and what belongs to them have no part in it. Without noise but that of the
/// position.
TwinDevice make_twin_device(const Model& model);

}  // namespace gyrator
