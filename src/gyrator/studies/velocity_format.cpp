#include "gyrator/studies/velocity_format.hpp"

namespace gyrator {
namespace {

using nlohmann::json;

// The default gains of the struct are those of the file.
const LevantEstimator levant_defaults{};
const AdaptiveWindowEstimator foaw_defaults{};

std::vector<ObjectSpec> linear_specs() {
  return {
      {"difference",
       "Difference over a window of samples.",
       {
           member::integer("window").by_default(1).at_least(1).at_most(1000).doc("Samples back."),
       }},
      {"filtered_difference",
       "Backward difference behind a first-order low-pass, both mapped backward.",
       {
           member::quantity("cutoff", dimension::frequency)
               .required()
               .above(0)
               .doc("Of the low-pass."),
       }},
      {"butterworth",
       "Backward difference behind a Butterworth low-pass, mapped by the trapezoidal rule.",
       {
           member::integer("order").by_default(2).at_least(1).at_most(8).doc("Of the low-pass."),
           member::quantity("cutoff", dimension::frequency)
               .required()
               .above(0)
               .doc("-3 dB frequency, met exactly; below half the sampling rate."),
       }}};
}

ObjectSpec foaw_spec(const MotionUnits& units) {
  return {"foaw",
          "First-order adaptive window: the slope over the longest window in which a line stays "
          "within the noise of every sample. Not linear: `simulate` only.",
          {
              member::quantity("noise", units.position)
                  .above(0)
                  .doc("Largest distance of a sample from the line; absent: the sensor's quantum."),
              member::integer("max_window")
                  .by_default(foaw_defaults.max_window)
                  .at_least(1)
                  .at_most(1000)
                  .doc("Longest window, samples back."),
              member::choice("fit", {"best", "end"})
                  .by_default("best")
                  .doc("The line's slope: of least squares, or through the window's ends."),
          }};
}

ObjectSpec levant_spec(const MotionUnits& units) {
  return {"levant",
          "Levant's robust exact differentiator of first order. Not linear: `simulate` only.",
          {
              member::quantity("acceleration_bound", units.acceleration)
                  .required()
                  .above(0)
                  .doc("Largest acceleration that it follows, L."),
              member::number("root_gain")
                  .by_default(levant_defaults.root_gain)
                  .above(0)
                  .doc("Of the square root of the error, in units of the root of L."),
              member::number("sign_gain")
                  .by_default(levant_defaults.sign_gain)
                  .above(1, "the estimate must outrun the acceleration bound")
                  .doc("Of the error's sign, in units of L."),
          }};
}

}  // namespace

std::vector<ObjectSpec> velocity_specs(const MotionUnits& units) {
  std::vector<ObjectSpec> specs = linear_specs();
  specs.push_back(foaw_spec(units));
  specs.push_back(levant_spec(units));
  return specs;
}

VelocityEstimator parse_velocity_estimator(const json& v, double quantum) {
  const std::string kind = v["kind"];
  if (kind == "difference") return DifferenceEstimator{v["window"]};
  if (kind == "filtered_difference") return FilteredDifferenceEstimator{v["cutoff"]};
  if (kind == "butterworth") return ButterworthEstimator{v["order"], v["cutoff"]};
  if (kind == "foaw") {
    return AdaptiveWindowEstimator{v["noise"].is_null() ? quantum : v["noise"].get<double>(),
                                   v["max_window"],
                                   v["fit"] == "end" ? WindowFit::end : WindowFit::best};
  }
  return LevantEstimator{v["acceleration_bound"], v["root_gain"], v["sign_gain"]};
}

}  // namespace gyrator
