#include "gyrator/sweeps/variation.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/sweeps/sweep_plan.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

const char* const model_text = R"({
  "motion": "rotary", "name": "test",
  "motor": {"torque_constant": 0.05, "resistance": "1.5 ohm"},
  "mechanics": {"inertia": 2e-5, "damping": 1e-4},
  "damping": [{"kind": "rc", "resistance": "5 ohm", "capacitance": "2200 uF"}],
  "sampling": {"period": "1 ms"},
  "controller": {"kind": "virtual_wall", "stiffness": 0.4, "damping": 1.5e-4}})";

const json& normal_model() {
  static const json normal = read_document(json::parse(model_text), model_format(), "");
  return normal;
}

Variation vary(const std::string& text) {
  return {parse_variation(text), normal_model(), model_format()};
}

std::string refusal(const std::string& text) {
  try {
    vary(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.what();
  }
  return "nothing was refused";
}

TEST(Variation, a_range_is_divided_evenly_and_meets_its_ends_exactly) {
  const Variation stiffness = vary("controller.stiffness=0.1..0.7:7");
  ASSERT_EQ(stiffness.count_grid_points(), 7U);
  EXPECT_EQ(stiffness.at_grid(0).number, 0.1);
  EXPECT_EQ(stiffness.at_grid(6).number, 0.7);
  // One rounding each of difference, product and sum, of numbers below 0.7.
  const double rounding = 3 * 0.7 * std::numeric_limits<double>::epsilon();
  for (std::size_t k = 0; k < 7; ++k)
    EXPECT_NEAR(stiffness.at_grid(k).number, 0.1 * static_cast<double>(k + 1), rounding);
  EXPECT_EQ(stiffness.unit(), "N.m/rad");
}

TEST(Variation, a_logarithmic_range_goes_by_equal_factors_and_meets_its_ends_exactly) {
  const Variation capacitance = vary("damping.0.capacitance=100uF..10mF:5log");
  ASSERT_EQ(capacitance.count_grid_points(), 5U);
  EXPECT_EQ(capacitance.at_grid(0).number, 100e-6);
  EXPECT_EQ(capacitance.at_grid(4).number, 10e-3);
  for (std::size_t k = 0; k < 5; ++k) {
    const double expected = 1e-4 * std::pow(10.0, 0.5 * static_cast<double>(k));
    EXPECT_NEAR(capacitance.at_grid(k).number / expected, 1, 1e-15 * 4);
  }
  EXPECT_EQ(capacitance.unit(), "F");
}

TEST(Variation, values_are_listed_with_units_and_kept_as_they_are) {
  const Variation resistance = vary("motor.resistance= 1 ohm, 4.7 kohm ,2.5");
  ASSERT_EQ(resistance.count_grid_points(), 3U);
  EXPECT_EQ(resistance.at_grid(1).number, 4700);
  EXPECT_EQ(resistance.at_grid(2).number, 2.5);
}

TEST(Variation, a_time_is_exact_and_a_range_of_times_is_one_of_whole_nanoseconds) {
  EXPECT_EQ(vary("sampling.period=1/60 s").at_grid(0).given, "1/60");
  const Variation period = vary("sampling.period=0.1 ms..0.2 ms:4");
  EXPECT_EQ(period.at_grid(1).given, "133333/1000000000");
  EXPECT_EQ(period.at_grid(1).number, 133333e-9);
  EXPECT_EQ(period.unit(), "s");
}

TEST(Variation, whole_numbers_choices_and_switches_vary_too) {
  const Variation seed = vary("simulation.seed=1..4:4");
  EXPECT_EQ(seed.at_grid(2).given, 3);
  const Variation sense = vary("amplifier.sense=total,motor");
  EXPECT_FALSE(sense.is_number());
  EXPECT_EQ(sense.at_grid(1).text, "motor");
  const Variation unilateral = vary("controller.unilateral=true,false");
  EXPECT_EQ(unilateral.at_grid(0).given, true);
  EXPECT_EQ(unilateral.at_grid(1).given, false);
}

TEST(Variation, a_share_of_a_list_takes_each_value_as_often) {
  const Variation list = vary("motor.resistance=1,2,3,4");
  int taken[4] = {};
  for (int i = 0; i < 100; ++i) ++taken[static_cast<int>(list.at_share(i / 100.0).number) - 1];
  for (const int times : taken) EXPECT_EQ(times, 25);
  EXPECT_EQ(list.at_share(std::nextafter(1.0, 0.0)).number, 4);
}

// n equal steps of u meet each of n whole numbers equally often, the ends like the others.
TEST(Variation, a_share_of_a_range_of_whole_numbers_takes_each_as_often) {
  for (const char* const range : {"simulation.seed=1..4", "simulation.seed=4..1"}) {
    const Variation seed = vary(range);
    int taken[4] = {};
    for (int i = 0; i < 100; ++i) ++taken[seed.at_share((i + 0.5) / 100).given.get<int>() - 1];
    for (const int times : taken) EXPECT_EQ(times, 25) << range;
    EXPECT_EQ(seed.at_share(0).given, range[16] - '0');
    EXPECT_EQ(seed.at_share(std::nextafter(1.0, 0.0)).given, '5' - range[16]);
  }
}

TEST(Variation, a_share_of_a_logarithmic_range_of_whole_numbers_favours_none_of_its_ends) {
  // From 1 to 3: v has the part log((v + 1)/v) of log 4.
  for (const char* const range : {"simulation.seed=1..3:log", "simulation.seed=3..1:log"}) {
    const Variation seed = vary(range);
    int taken[3] = {};
    for (int i = 0; i < 1000; ++i) ++taken[seed.at_share((i + 0.5) / 1000).given.get<int>() - 1];
    for (int v = 1; v <= 3; ++v) {
      const double expected = 1000 * std::log((v + 1.0) / v) / std::log(4.0);
      EXPECT_NEAR(taken[v - 1], expected, 1) << range << v;  // one step of u at the borders
    }
  }
}

TEST(Variation, the_folder_above_is_no_range) {
  const VariationText text = parse_variation("damping.0.file=../a.cir,b/../../c.cir");
  ASSERT_EQ(text.values.size(), 2U);
  EXPECT_EQ(text.values[0], "../a.cir");
  EXPECT_EQ(text.values[1], "b/../../c.cir");
}

TEST(Variation, an_unknown_key_is_refused_with_the_nearest_one) {
  const std::string message = refusal("damping.0.capacitence=1uF,2uF");
  EXPECT_NE(message.find("--vary damping.0.capacitence"), std::string::npos) << message;
  EXPECT_NE(message.find("did you mean 'capacitance'?"), std::string::npos) << message;
}

TEST(Variation, what_the_model_does_not_allow_is_refused_before_anything_is_computed) {
  for (const auto& [text, fragment] :
       {std::pair{"damping.0.capacitance=1 ohm,2 ohm", "capacitance [F]"},
        std::pair{"damping.0.capacitance=0..1uF:3", "must be above 0 F"},
        std::pair{"damping.0.capacitance=100..500uF:3", "only one end of the range has a unit"},
        std::pair{"damping.3.capacitance=1uF", "from 0 to 0"},
        std::pair{"damping=1", "is a list of 1"},
        std::pair{"controller.kind=virtual_wall", "cannot vary"},
        std::pair{"motion=rotary,linear", "cannot vary"},
        std::pair{"controller.stiffness=-1..1:5log", "logarithmic range"},
        std::pair{"amplifier.sense=total..motor:2", "has no range"},
        std::pair{"controller.stiffness=0.1,,0.2", "a value is missing"},
        std::pair{"controller.stiffness=0.1..0.2:0", "a number of points"},
        std::pair{"controller.stiffness=0.1..0.2:1", "would leave out its end"},
        std::pair{"controller.stiffness", "PATH=FROM..TO:N"}}) {
    const std::string message = refusal(text);
    EXPECT_NE(message.find(fragment), std::string::npos) << text << ": " << message;
  }
}

SweepStudy study_of(const std::vector<std::string>& texts) {
  SweepStudy study;
  study.file = study.model_file = "model.json";
  study.model_text = model_text;
  study.analysis = "zwidth";
  for (const auto& text : texts) study.vary.push_back(parse_variation(text));
  return study;
}

TEST(SweepPlan, the_last_variation_changes_fastest) {
  const SweepPlan plan(study_of({"motor.resistance=1,2", "controller.stiffness=0.1,0.2,0.3"}));
  ASSERT_EQ(plan.size(), 6U);
  const double expected[6][2] = {{1, 0.1}, {1, 0.2}, {1, 0.3}, {2, 0.1}, {2, 0.2}, {2, 0.3}};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(plan.values_at(i)[0].number, expected[i][0]);
    EXPECT_EQ(plan.values_at(i)[1].number, expected[i][1]);
    EXPECT_EQ(plan.document_at(i)["controller"]["stiffness"], expected[i][1]);
  }
  EXPECT_EQ(plan.describe_point(4), "motor.resistance = 2 ohm, controller.stiffness = 0.2 N.m/rad");
}

TEST(SweepPlan, sobol_points_are_those_of_the_published_directions) {
  // Joe and Kuo 2008, the first points in two dimensions after the origin.
  SweepStudy study = study_of({"motor.resistance=1..2", "controller.stiffness=1..2"});
  study.sampling = SamplingKind::sobol;
  study.samples = 7;
  const SweepPlan plan(study);
  const double shares[7][2] = {{0.5, 0.5},     {0.75, 0.25},   {0.25, 0.75},  {0.375, 0.375},
                               {0.875, 0.875}, {0.625, 0.125}, {0.125, 0.625}};
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(plan.values_at(i)[0].number, 1 + shares[i][0]) << i;
    EXPECT_EQ(plan.values_at(i)[1].number, 1 + shares[i][1]) << i;
  }
}

TEST(SweepPlan, a_random_point_depends_on_seed_and_number_alone) {
  SweepStudy study = study_of({"motor.resistance=1..2", "controller.stiffness=1..2"});
  study.sampling = SamplingKind::random;
  study.samples = 10;
  study.seed = 4;
  const SweepPlan plan(study);
  study.samples = 3;
  const SweepPlan shorter(study);
  study.seed = 5;
  const SweepPlan other(study);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(plan.values_at(i)[1].number, shorter.values_at(i)[1].number);
    EXPECT_NE(plan.values_at(i)[1].number, other.values_at(i)[1].number);
    EXPECT_NE(plan.values_at(i)[0].number, plan.values_at(i)[1].number);
    EXPECT_NE(plan.values_at(i)[0].number, plan.values_at(i + 1)[0].number);
  }
}

TEST(SweepPlan, its_digest_is_that_of_all_that_decides_a_number) {
  const SweepStudy study = study_of({"motor.resistance=1,2"});
  const std::string digest = SweepPlan(study).digest();
  EXPECT_EQ(SweepPlan(study).digest(), digest);
  SweepStudy other = study;
  other.timeout_s = 3;  // how it is run, not what
  other.keep_going = true;
  EXPECT_EQ(SweepPlan(other).digest(), digest);
  other = study;
  other.model_text += " ";
  EXPECT_NE(SweepPlan(other).digest(), digest);
  other = study;
  other.analysis = "coupled";
  EXPECT_NE(SweepPlan(other).digest(), digest);
  EXPECT_NE(SweepPlan(study_of({"motor.resistance=1,3"})).digest(), digest);
}

TEST(SweepStudy, a_study_file_and_its_description_say_the_same) {
  SweepStudy study =
      study_of({"motor.resistance=1 ohm..2 ohm:5log", "controller.stiffness=0.1,0.2"});
  study.sampling = SamplingKind::random;
  study.samples = 9;
  study.seed = 3;
  const SweepStudy again = parse_study(describe_study(study), "study.json");
  EXPECT_EQ(describe_study(again), describe_study(study));
  EXPECT_EQ(again.vary[0].points, 5U);
  EXPECT_TRUE(again.vary[0].logarithmic);
  EXPECT_EQ(again.seed, 3U);
}

}  // namespace
}  // namespace gyrator
