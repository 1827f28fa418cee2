#include "gyrator/regression/regression_study.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/regression/baseline.hpp"
#include "gyrator/regression/overridden_model.hpp"

#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

json make_study() {
  return json::parse(R"({
    "schema": "gyrator/regression/1", "name": "A study",
    "runs": [{
      "name": "one", "command": "simulate", "model": "m.json",
      "vary": { "sampling.period": ["1 ms", "2 ms"], "controller.stiffness": [1, 2] },
      "exit_code": [0, 1],
      "expect": [{ "figure": "growth", "unit": "N.m", "tolerance": { "absolute": "1 mN.m" } },
                 { "figure": "classification", "equals": "settles" }],
      "trace": { "columns": { "position": { "absolute": "1 um" } }, "time": "1 ms" }
    }],
    "figures": [{ "name": "f", "x": { "label": "x" }, "y": { "label": "y" },
                  "curves": [{ "run": "one", "x": "set.sampling.period", "y": "growth" }] }]
  })");
}

void expect_refused(const std::string& pointer, const json& value, const std::string& place,
                    const std::string& part) {
  json study = make_study();
  study[json::json_pointer(pointer)] = value;
  try {
    parse_regression_study(study, "s.json");
    ADD_FAILURE() << pointer << " = " << value << " was taken";
  } catch (const Error& error) {
    EXPECT_NE(error.place().find(place), std::string::npos) << error.what();
    EXPECT_NE(error.message().find(part), std::string::npos) << error.what();
  }
}

TEST(RegressionStudy, AStudyIsReadWithItsUnits) {
  const RegressionStudy study = parse_regression_study(make_study(), "s.json");
  const RegressionRun& run = study.runs.at(0);
  EXPECT_EQ(run.points(), 2U);
  EXPECT_EQ(run.exit_codes, (std::vector<int>{0, 1}));
  EXPECT_EQ(run.expect.at(0).tolerance.value().absolute, 0.001);
  EXPECT_EQ(run.expect.at(0).name, "growth");
  EXPECT_FALSE(run.expect.at(1).tolerance);  // exact: no baseline
  EXPECT_EQ(run.trace.value().columns.at(0).absolute, 1e-6);
  EXPECT_EQ(run.trace.value().time_s, 0.001);
}

TEST(RegressionStudy, WhatHasNoToleranceTakesTheStudys) {
  json study = make_study();
  study["runs"][0]["expect"] = json::parse(R"([{"figure": "growth"}])");
  EXPECT_EQ(parse_regression_study(study, "").runs[0].expect[0].tolerance.value().relative, 1e-6);
  study["tolerance"] = {{"relative", 0.5}};
  EXPECT_EQ(parse_regression_study(study, "").runs[0].expect[0].tolerance.value().relative, 0.5);
}

TEST(RegressionStudy, WhatMakesNoSenseIsRefusedByName) {
  expect_refused("/runs/0/name", "a/b", "/runs/0/name", "letters, digits");
  expect_refused("/runs/0/vary/damping.0.capacitance", {1, 2, 3}, "/runs/0/vary", "lockstep");
  expect_refused("/runs/0/exit_code", {0, 1, 1}, "/runs/0/exit_code", "3 exit codes for 2 values");
  expect_refused("/runs/0/expect/0/tolerance/absolute", "1 mm", "/tolerance/absolute",
                 "the figure is in N.m");
  expect_refused("/runs/0/expect/0/unit", "mN.m", "/expect/0/unit", "answers are in SI units");
  expect_refused("/runs/0/expect/1/figure", "growth", "/runs/0/expect", "is there twice");
  expect_refused("/runs/0/command", "passivity", "/runs/0/trace", "simulate only");
  expect_refused("/runs/0/arguments", json::array({"--json"}), "/runs/0/arguments", "itself");
  expect_refused("/runs/0/arguments", json::array({"-oX.json"}), "/runs/0/arguments", "itself");
  expect_refused("/runs/0/set", {{"sampling.period", 1}}, "/runs/0/vary", "in \"set\" too");
  expect_refused("/runs/0/trace/columns/position", json::object(), "/columns/position", "how wide");
  expect_refused("/runs/0/expct", 1, "/runs/0/expct", "did you mean 'expect'");
  expect_refused("/figures/0/curves/0/run", "on", "/figures/0/curves/0/run", "did you mean 'one'");
  expect_refused("/runs/0/expect/0/published", {{"value", 1}, {"source", "x"}}, "/published",
                 "how near");
}

TEST(RegressionStudy, ASeedIsToldOnce) {
  json study = make_study();
  study["runs"][0]["seed"] = 1;
  parse_regression_study(study, "s.json");
  for (const auto& [where, told] :
       {std::pair<std::string, json>{"/runs/0/set", {{"simulation.seed", 2}}},
        {"/runs/0/vary/simulation.seed", {2, 3}},
        {"/runs/0/arguments", json::array({"--seed", "2"})},
        {"/runs/0/arguments", json::array({"--seed=2"})}}) {
    json twice = study;
    twice[json::json_pointer(where)] = told;
    try {
      parse_regression_study(twice, "s.json");
      ADD_FAILURE() << where << " = " << told << " was taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.place(), "s.json: /runs/0/seed");
      EXPECT_NE(error.message().find("one of them is enough"), std::string::npos) << error.what();
    }
  }
}

TEST(Baseline, ATextIsReadBackAsItWas) {
  Baseline baseline{"A study", {}};
  baseline.runs["one"] = {{{"program", "gyrator"}},
                          {{"K", {0.1 + 0.2, "N/m", "± 1 %"}}, {"list", {{1, nullptr}, "", ""}}}};
  const std::string text = write_baseline_text(baseline);
  const Baseline read = parse_baseline(json::parse(text), "b.json");
  EXPECT_EQ(read.runs.at("one").figures.at("K").value, 0.1 + 0.2);
  EXPECT_EQ(read.runs.at("one").figures.at("list").value, json({1, nullptr}));
  EXPECT_EQ(write_baseline_text(read), text);
}

TEST(Baseline, WhatIsNoBaselineIsRefused) {
  EXPECT_THROW(parse_baseline(json::parse(R"({"schema": "gyrator/baseline/1"})"), "b"), Error);
  EXPECT_THROW(parse_baseline(json::parse(R"({"schema": "gyrator/baseline/1", "study": "s",
                 "runs": {"one": {"figures": {"K": {"valu": 1}}, "provenance": {}}}})"),
                              "b"),
               Error);
}

TEST(OverridableModel, AValueReplacesTheModelsAndFilesAreFoundFromAnywhere) {
  const OverridableModel model("examples/recorded_push.json");
  const json changed = model.with_values({{"simulation.seed", 7, "s.json: /runs/0/set"}});
  EXPECT_EQ(changed["simulation"]["seed"], 7);
  EXPECT_EQ(model.value_of(changed, "simulation.seed"), 7);
  EXPECT_NE(changed.dump().find("/examples/push.csv"), std::string::npos);
  EXPECT_EQ(model.hash_named_files().count("push.csv"), 1U);
}

TEST(OverridableModel, ToleratedPartsKeepTheirTolerance) {
  const OverridableModel model("examples/rc_display_tolerance.json");
  const json changed = model.with_values({{"controller.stiffness", "0.05 N.m/rad", ""}});
  EXPECT_NE(changed.dump().find("±"), std::string::npos);
  EXPECT_EQ(model.value_of(changed, "controller.stiffness"), 0.05);
}

}  // namespace
}  // namespace gyrator
