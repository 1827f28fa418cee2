#include "gyrator/studies/sampling_format.hpp"

#include "gyrator/core/error.hpp"

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

Rational time_of(const json& value) {
  return Rational::from_text(value.get<std::string>());
}

}  // namespace

ObjectSpec sensor_spec(const MotionUnits& units) {
  const ObjectSpec filter{
      "filter",
      "An analog low-pass in front of the sampler. It has followed the initial velocity for long "
      "when a run starts. An analog wall (held_impedance) acts on the unfiltered position.",
      {
          member::quantity("cutoff", dimension::frequency)
              .required()
              .above(0)
              .doc("-3 dB frequency."),
          member::integer("order").by_default(1).at_least(1).at_most(2).doc(
              "1, or 2 (Butterworth)."),
      }};
  return {
      "sensor",
      "The position sensor.",
      {
          member::quantity("quantum", units.quantum)
              .by_default(0)
              .at_least(0)
              .doc("Step of the encoder; 0 for none. The nearest multiple is sensed, halves up."),
          member::quantity("offset", units.position)
              .by_default(0)
              .doc("Added to the sensed position."),
          member::quantity("noise", units.position)
              .by_default(0)
              .at_least(0)
              .doc("Standard deviation of normal noise that comes to the position before it is "
                   "rounded, new at each sample; for `simulate`, from simulation.seed."),
          member::choice("location", {"port", "motor"})
              .by_default("port")
              .doc("Differs only behind a compliant transmission."),
          member::object("filter", filter)
              .doc("Analog low-pass between the sensor and the sampler; absent: none."),
      }};
}

ObjectSpec sampling_spec() {
  return {"sampling",
          "The controller's clock.",
          {
              member::time("period").required().above(0).doc(
                  "Between samples; exact, \"1/60 s\" is possible."),
              member::time("delay").by_default(0).at_least(0).doc(
                  "From sampling to the command taking effect; any length, fractions of the period "
                  "included."),
              member::time("jitter").by_default(0).at_least(0).doc(
                  "Each sample comes at a random time within plus or minus this, below half a "
                  "period, around its due time; for `simulate`, from simulation.seed. The "
                  "controller and the linear tools take the clock as even."),
              member::time("slow_period")
                  .above(0)
                  .doc("Of a slower environment, where its \"update\" gives no period."),
          }};
}

ObjectSpec dac_spec(const MotionUnits& units) {
  return {"dac",
          "The converter between controller and amplifier; for `simulate`.",
          {
              member::quantity("quantum", units.effort)
                  .by_default(0)
                  .at_least(0)
                  .doc("Step; 0 for none. The nearest multiple is put out, halves up."),
              member::quantity("limit", units.effort)
                  .above(0)
                  .doc("Largest effort that it can ask for, either way; absent: none."),
          }};
}

Sensor parse_sensor(const json& sensor) {
  return {sensor["quantum"], sensor["offset"], sensor["noise"]};
}

std::optional<SensorFilter> parse_sensor_filter(const json& sensor) {
  const json& filter = sensor["filter"];
  if (filter.is_null()) return std::nullopt;
  return SensorFilter{filter["cutoff"], filter["order"]};
}

Sampling parse_sampling(const json& sampling, const std::string& file) {
  const Sampling parsed{time_of(sampling["period"]), time_of(sampling["delay"]),
                        time_of(sampling["jitter"])};
  if (parsed.jitter * 2 >= parsed.period) {
    throw Error(ErrorCode::bad_input, file + ": /sampling/jitter",
                fmt::format("{:g} s: must be below half the period, {:g} s",
                            parsed.jitter.to_double(), (parsed.period / 2).to_double()));
  }
  return parsed;
}

Dac parse_dac(const json& dac) {
  Dac parsed{dac["quantum"], std::nullopt};
  if (!dac["limit"].is_null()) parsed.limit = dac["limit"];
  return parsed;
}

}  // namespace gyrator
