#include "gyrator/synthesis/digital_stage.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/synthesis/design_search.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr double R_m = 2.06;
constexpr double L_m = 0.238e-3;
constexpr double T = 1e-3;

json digital_spec(const json& digital) {
  return {{"schema", "gyrator/design/1"},
          {"model", "examples/compare/re25_none.json"},
          {"objective", {{"maximize", "stiffness"}, {"virtual_damping", 1e-4}}},
          {"topologies", {"rc"}},
          {"series", "none"},
          {"constraints", {{"apparent_inertia", {{"max", 5e-7}}}}},
          {"operation", {{"effort", 0.01}, {"frequency", 100}}},
          {"digital", digital}};
}

DesignSpec parse(const json& document) {
  return parse_design_spec(document, "spec.json");
}

TEST(DigitalStage, TheOutputStageIsTheInverseOfTheRcBranchsLag) {
  const DesignSpec spec = parse(digital_spec({{"pre_emphasis", true}}));
  ASSERT_EQ(spec.options.size(), 2U);
  const DesignProblem problem(spec, spec.options[1]);
  const std::vector<double> values{4.7, 470e-6};
  const Controller controller = problem.make_controller(problem.make_device(values), values);
  const DiscreteStateSpace stage = make_output_law(controller);
  // A = (1 + R C s)/(1 + (R + R_m) C s + L C s^2), the amplifier's lag left out: at 50 Hz, far
  // below its 5 kHz and Nyquist, F A = 1 but for the mapping's second order, (w T)^2/2.
  const std::complex<double> s(0, 2 * std::numbers::pi * 50);
  const auto A = (1.0 + 4.7 * 470e-6 * s) / (1.0 + (4.7 + R_m) * 470e-6 * s + L_m * 470e-6 * s * s);
  const double error = std::norm(s) * T * T / 2;
  EXPECT_NEAR(std::abs(stage.response(std::exp(s * T)) * A), 1, error);
  EXPECT_NEAR(std::abs(stage.response(1.0)), 1, 1e-12);
  const double gain = find_emphasis_gain(controller);
  EXPECT_GE(gain, std::abs(stage.response(-1.0)));
  EXPECT_GT(gain, (4.7 + R_m) / 4.7);
}

TEST(DigitalStage, TheAmplifierMustGiveWhatTheStageAsksFor) {
  json bounded = digital_spec({{"pre_emphasis", true}});
  bounded["constraints"]["amplifier_current"] = {{"max", 10}};
  const DesignSpec extremes = parse(bounded);
  const std::vector<double> values{4.7, 470e-6};
  const DesignProblem plain(extremes, extremes.options[0]);
  const DesignProblem raised(extremes, extremes.options[1]);
  const DiscreteStateSpace stage =
      make_output_law(raised.make_controller(raised.make_device(values), values));
  // Without motion the amplifier's current is the command's times the stage's gain; most at the
  // highest frequency, where the gain is highest.
  const double gain = std::abs(stage.response(std::polar(1.0, 2 * std::numbers::pi * 100 * T)));
  EXPECT_GT(gain, 1.05);
  EXPECT_NEAR(raised.evaluate(values).extremes.amplifier_current /
                  plain.evaluate(values).extremes.amplifier_current,
              gain, 1e-9 + 1e-3 * gain);
}

TEST(DigitalStage, AWiderChoiceIsNeverWorse) {
  const DesignSpec plain = parse(digital_spec(json::object()));
  const DesignSpec wide =
      parse(digital_spec({{"pre_emphasis", true}, {"velocity_cutoff", {"20 Hz", "2 kHz"}}}));
  ASSERT_EQ(plain.options.size(), 1U);
  ASSERT_EQ(wide.options.size(), 4U);
  // What the plain spec has is one of the choices.
  EXPECT_FALSE(wide.options.front().pre_emphasis || wide.options.front().velocity_filter);
  const DesignMerit own = search_option(DesignProblem(plain, plain.options.front())).best.merit;
  const Candidate both = search_option(DesignProblem(wide, wide.options.back())).best;
  EXPECT_LE(both.figures.emphasis_gain, 10 * (1 + 1e-9));
  // The branch's lag is what binds this motor at B: without it and with a filter, a half more.
  EXPECT_GT(both.merit.score, 1.4 * own.score);
}

TEST(DigitalStage, TheGainOfTheStageIsBounded) {
  json document = digital_spec({{"pre_emphasis", true}});
  document["constraints"]["emphasis_gain"] = {{"max", 1.5}};
  const DesignSpec spec = parse(document);
  const Candidate found = search_option(DesignProblem(spec, spec.options[1])).best;
  ASSERT_TRUE(found.merit.feasible);
  EXPECT_LE(found.figures.emphasis_gain, 1.5 * (1 + 1e-9));
  EXPECT_GT(found.figures.emphasis_gain, 1);
}

TEST(DigitalStage, TheModelsKindOfFilterIsKept) {
  const auto butterworth = with_cutoff(ButterworthEstimator{3, 100}, 40);
  ASSERT_TRUE(std::holds_alternative<ButterworthEstimator>(butterworth));
  EXPECT_EQ(std::get<ButterworthEstimator>(butterworth).order, 3);
  EXPECT_EQ(std::get<ButterworthEstimator>(butterworth).cutoff_hz, 40);
  const auto filtered = with_cutoff(DifferenceEstimator{}, 40);
  EXPECT_EQ(std::get<FilteredDifferenceEstimator>(filtered).cutoff_hz, 40);
}

TEST(DigitalStage, TheModelFileIsWhatWasJudged) {
  const DesignSpec spec =
      parse(digital_spec({{"pre_emphasis", true}, {"velocity_cutoff", {"20 Hz", "2 kHz"}}}));
  const DesignProblem problem(spec, spec.options.back());
  const std::vector<double> values{3.3, 680e-6, 70};
  const Model written =
      parse_model(make_designed_model(spec, spec.options.back(), {3.3, 680e-6, 70}), "m.json");
  const Controller judged = problem.make_controller(problem.make_device(values), values);
  for (const double hz : {1.0, 60.0, 500.0}) {
    const auto z = std::polar(1.0, 2 * std::numbers::pi * hz * T);
    EXPECT_NEAR(std::abs(make_output_law(written.controller).response(z) -
                         make_output_law(judged).response(z)),
                0, 1e-12);
  }
  const auto& wall = std::get<VirtualWall>(written.controller.law);
  EXPECT_EQ(std::get<FilteredDifferenceEstimator>(wall.velocity).cutoff_hz, 70);
}

}  // namespace
}  // namespace gyrator
