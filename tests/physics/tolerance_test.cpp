// A plant of inertia and damper under an ideal drive has K_max = 2 b/T at B = 0, so that the
// distribution of its limit over the tolerance of b is known in closed form.

#include "gyrator/core/error.hpp"
#include "gyrator/studies/tolerance_study.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr double T = 1e-3;
constexpr double low_damping = 0.8e-3;
constexpr double high_damping = 1.4e-3;

// b in [0.8, 1.4] mN.m.s/rad around 1, so that K_max is in [1.6, 2.8] N.m/rad.
Model make_plant(double stiffness) {
  return parse_model({{"motion", "rotary"},
                      {"mechanics",
                       {{"inertia", "2e-5 kg.m^2 ± 20 %"},
                        {"damping", "1 mN.m.s/rad (0.8 mN.m.s/rad to 1.4 mN.m.s/rad)"}}},
                      {"amplifier", {{"kind", "ideal"}}},
                      {"sampling", {{"period", T}}},
                      {"controller", {{"kind", "virtual_wall"}, {"stiffness", stiffness}}}},
                     "p3.json");
}

constexpr int many = 400;  // samples, for what is random

// Of the disk's limit near Nyquist, which the grid reaches.
constexpr double limit_accuracy = 1e-6;

TEST(ToleranceStudy, every_sample_has_its_own_2b_over_T) {
  ToleranceRequest request;
  request.samples = 400;
  const ToleranceStudy study = run_tolerance_study(make_plant(2), request);
  for (const BoxPoint& sample : study.samples) {
    const double limit = 2 * sample.values[1] / T;
    EXPECT_NEAR(sample.limit.max_stiffness, limit, limit_accuracy * limit);
    EXPECT_EQ(sample.limit.outcome == WallOutcome::passive, sample.limit.max_stiffness > 2);
  }
  EXPECT_NEAR(study.nominal.max_stiffness, 2, 2 * limit_accuracy);
}

// Share of the samples whose limit is above K, as it is and as the distribution of b gives it.
void expect_yield(SampleDistribution distribution, double K, double expected) {
  ToleranceRequest request;
  request.samples = many;
  request.distribution = distribution;
  const Model model = make_plant(K);
  const json result =
      make_tolerance_result(model, request, run_tolerance_study(model, request))["samples"];
  // Five standard deviations of the share; the seed is fixed.
  const double reach = 5 * std::sqrt(expected * (1 - expected) / many);
  EXPECT_NEAR(result["yield"], expected, reach) << name_of(distribution) << ", K = " << K;
  EXPECT_LE(result["yield_low"], result["yield"]);
  EXPECT_EQ(result["outcomes"]["passive"].get<int>() + result["outcomes"]["too_stiff"].get<int>(),
            many);
}

TEST(ToleranceStudy, yield_of_uniform_parts_is_the_share_of_the_range_above) {
  for (const double K : {1.7, 2.2, 2.7})
    expect_yield(SampleDistribution::uniform, K,
                 (high_damping - K * T / 2) / (high_damping - low_damping));
}

// Half of the samples on either side of 1 mN.m.s/rad, z of a standard normal cut at 3.
TEST(ToleranceStudy, yield_of_normal_parts_is_the_tail_of_a_cut_normal) {
  const auto above = [](double z) {
    const auto tail = [](double x) { return std::erfc(x / std::sqrt(2.0)) / 2; };
    return (tail(z) - tail(3)) / (1 - 2 * tail(3));
  };
  expect_yield(SampleDistribution::normal, 2.2, above(0.1 / 0.4 * 3));
  expect_yield(SampleDistribution::normal, 1.9, above(-0.05 / 0.2 * 3));
}

TEST(ToleranceStudy, quantiles_are_those_of_the_uniform_distribution) {
  ToleranceRequest request;
  request.samples = many;
  const Model model = make_plant(1.5);
  const json samples =
      make_tolerance_result(model, request, run_tolerance_study(model, request))["samples"];
  for (const auto& quantile : samples["quantiles"]) {
    const double p = quantile["probability"];
    // Five standard deviations of an order statistic, at least those of the first one.
    const double reach = 5 * std::sqrt(std::max(p * (1 - p), 1.0 / many) / many);
    EXPECT_NEAR((quantile["max_stiffness"].get<double>() - 1.6) / 1.2, p, reach);
  }
  EXPECT_NEAR(samples["mean"], 2.2, 5 * 1.2 / std::sqrt(12.0 * many));
  // The sample variance of a uniform distribution scatters by sqrt(0.8/n) of itself.
  const double deviation = 1.2 / std::sqrt(12.0);
  EXPECT_NEAR(samples["standard_deviation"], deviation, 5 * deviation * std::sqrt(0.8 / many) / 2);
}

TEST(ToleranceStudy, worst_case_is_the_least_damping_and_decides_from_both_sides) {
  ToleranceRequest request;
  request.samples = 50;
  constexpr double worst = 2 * low_damping / T;
  for (const bool below : {true, false}) {
    const double K = worst * (below ? 1 - 1e-3 : 1 + 1e-3);
    const ToleranceStudy study = run_tolerance_study(make_plant(K), request);
    EXPECT_NEAR(study.worst.limit.max_stiffness, worst, limit_accuracy * worst);
    EXPECT_EQ(study.worst.values[1], low_damping);
    // No sample comes as low as the corner: without it the wall would seem safe.
    EXPECT_TRUE(std::all_of(study.samples.begin(), study.samples.end(), [](const BoxPoint& s) {
      return s.limit.outcome == WallOutcome::passive;
    }));
    EXPECT_EQ(is_robust(study), below);
  }
}

TEST(ToleranceStudy, only_the_damping_matters_and_in_proportion) {
  ToleranceRequest request;
  request.samples = 200;
  const ToleranceStudy study = run_tolerance_study(make_plant(1), request);
  ASSERT_EQ(study.effects.size(), 2U);
  const PartEffect& damping = study.effects[0];
  EXPECT_EQ(damping.part, 1U);
  EXPECT_NEAR(damping.at_low, 1.6, 1e-5);
  EXPECT_NEAR(damping.at_high, 2.8, 1e-5);
  EXPECT_NEAR(*damping.elasticity, 1, 1e-4);
  EXPECT_NEAR(*damping.sensitivity, 0.3, 1e-4);  // 0.6 mN.m.s/rad of range, half of it, over 1
  EXPECT_GT(damping.rank_correlation, 0.9999);
  const PartEffect& inertia = study.effects[1];
  EXPECT_NEAR(*inertia.elasticity, 0, 1e-4);
  EXPECT_LT(std::abs(inertia.rank_correlation), 5 / std::sqrt(200.0));
}

TEST(ToleranceStudy, samples_hang_on_the_seed_and_on_nothing_else) {
  const auto limits = [](std::uint64_t seed, int threads) {
    ToleranceRequest request;
    request.samples = 100;
    request.seed = seed;
    request.threads = threads;
    const Model model = make_plant(2);
    return make_tolerance_result(model, request, run_tolerance_study(model, request)).dump();
  };
  const std::string once = limits(7, 1);
  EXPECT_EQ(once, limits(7, 1));
  EXPECT_EQ(once, limits(7, 4));
  EXPECT_NE(once, limits(8, 1));
}

TEST(ToleranceStudy, devices_that_fail_by_themselves_are_counted_as_such) {
  // Cancelled beyond its own resistance the winding's current grows, port held: R_m < R_c, a
  // quarter of the range. The rest is damped by K_t^2/(R_m - R_c), far above what the wall needs.
  json document = {{"motion", "rotary"},
                   {"motor",
                    {{"torque_constant", "50 mN.m/A"},
                     {"resistance", "2 ohm to 3 ohm"},
                     {"inductance", "0.5 mH"}}},
                   {"mechanics", {{"inertia", "2e-5 kg.m^2"}, {"damping", 1e-3}}},
                   {"amplifier", {{"kind", "voltage"}}},
                   {"damping", {{{"kind", "resistance_cancellation"}, {"resistance", "2.25 ohm"}}}},
                   {"sampling", {{"period", T}}},
                   {"controller", {{"kind", "virtual_wall"}, {"stiffness", 0.01}}}};
  const Model model = parse_model(document, "m");
  ToleranceRequest request;
  request.samples = 400;
  const ToleranceStudy study = run_tolerance_study(model, request);
  int unstable = 0;
  for (const BoxPoint& sample : study.samples) {
    const bool is_unstable = sample.limit.outcome == WallOutcome::device_unstable;
    unstable += is_unstable ? 1 : 0;
    EXPECT_EQ(is_unstable, sample.values[0] < 2.25) << sample.values[0];
  }
  EXPECT_NEAR(unstable / 400.0, 0.25, 5 * std::sqrt(0.25 * 0.75 / 400));
  EXPECT_FALSE(is_robust(study));
  EXPECT_EQ(study.worst.limit.outcome, WallOutcome::device_unstable);
}

// A motor of 5 % tolerance under a drive whose command goes by the nominal one.
json make_motor_model(const json& damping, const char* amplifier) {
  return {
      {"motion", "rotary"},
      {"motor",
       {{"torque_constant", "50 mN.m/A ± 5 %"}, {"resistance", "2 ohm"}, {"inductance", "0.2 mH"}}},
      {"mechanics", {{"inertia", "2e-5 kg.m^2"}, {"damping", 1e-4}}},
      {"amplifier", {{"kind", amplifier}}},
      {"damping", {damping}},
      {"sampling", {{"period", T}}},
      {"controller", {{"kind", "virtual_wall"}, {"stiffness", 0.01}}}};
}

// One pole w_b in an analog loop whose gain is the motor's, g = K_t/K_t0: g K <= b w_b.
TEST(ToleranceStudy, the_loop_of_a_held_impedance_is_as_strong_as_the_motor) {
  const Model model = parse_model(
      make_motor_model({{"kind", "held_impedance"}, {"bandwidth", "2 kHz"}}, "current"), "m");
  const LimitSampler sampler(model);
  for (const double g : {0.95, 1.0, 1.05}) {
    const double expected = 1e-4 * 2 * std::acos(-1.0) * 2000 / g;
    EXPECT_NEAR(sampler.at(std::vector<double>{0.05 * g}).max_stiffness, expected, 1e-6 * expected);
  }
}

// Waves between controller and resistor are electrical: whatever the motor turns them into, no
// wall reflects more than it gets.
TEST(ToleranceStudy, a_wave_drive_stays_passive_whatever_its_motor) {
  json document = make_motor_model({{"kind", "wave"}, {"impedance", "1 mN.m.s/rad"}}, "voltage");
  document["controller"] = {{"kind", "wave"},
                            {"environment", {{"kind", "virtual_wall"}, {"stiffness", 0.01}}}};
  ToleranceRequest request;
  request.samples = 10;
  const ToleranceStudy study = run_tolerance_study(parse_model(document, "m"), request);
  EXPECT_TRUE(is_robust(study));
  EXPECT_TRUE(std::isinf(study.worst.limit.max_stiffness));
  EXPECT_EQ(study.worst.found_by, "nominal") << "nothing is worse than another without a limit";
}

TEST(ToleranceStudy, what_it_cannot_study_is_refused) {
  const auto message = [](json document) {
    try {
      run_tolerance_study(parse_model(document, "m.json"), {});
    } catch (const Error& error) {
      return error.place() + ": " + error.message();
    }
    return std::string("no error");
  };
  json document = {{"motion", "rotary"},
                   {"mechanics", {{"inertia", 2e-5}, {"damping", 1e-3}}},
                   {"amplifier", {{"kind", "ideal"}}},
                   {"sampling", {{"period", T}}},
                   {"controller", {{"kind", "virtual_wall"}, {"stiffness", 1}}}};
  EXPECT_NE(message(document).find("no quantity has a tolerance"), std::string::npos);
  document["mechanics"]["damping"] = "1e-3 ± 5 %";
  document["controller"] = {{"kind", "none"}};
  EXPECT_NE(message(document).find("m.json: /controller/kind: no wall"), std::string::npos);
}

}  // namespace
}  // namespace gyrator
