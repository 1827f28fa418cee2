#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/cosim/command_path.hpp"
#include "gyrator/cosim/sensor.hpp"
#include "gyrator/documents/document_spec.hpp"
#include "gyrator/mechanics/device.hpp"
#include "gyrator/studies/model_format.hpp"

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

// The keys "sensor", "sampling" and "dac" of a model file: their tables, and what they say. The
// documents parsed have been validated by the tables.

ObjectSpec sensor_spec(const MotionUnits& units);
ObjectSpec sampling_spec();
ObjectSpec dac_spec(const MotionUnits& units);

Sensor parse_sensor(const nlohmann::json& sensor);
std::optional<SensorFilter> parse_sensor_filter(const nlohmann::json& sensor);
/// Throws bad_input, naming the model's file, for a jitter of half a period and more.
Sampling parse_sampling(const nlohmann::json& sampling, const std::string& file);
Dac parse_dac(const nlohmann::json& dac);

}  // namespace gyrator
