#include "gyrator/regression/answer_path.hpp"

#include "gyrator/core/error.hpp"

#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

const json& answer() {
  static const json value = json::parse(R"({
    "verdict": "passive",
    "criteria": [
      { "name": "textbook", "holds": true, "max_stiffness": 0.5, "order": 1 },
      { "name": "exact_disk", "holds": false, "max_stiffness": 0.0658, "order": 2.5 }
    ],
    "trace": { "position": [0.1, null, 0.4, -0.2] },
    "empty": []
  })");
  return value;
}

std::string refusal(const std::string& path) {
  try {
    find_in_answer(answer(), path);
  } catch (const Error& error) {
    return error.message();
  }
  return "";
}

void expect_refused(const std::string& path, const std::string& part) {
  EXPECT_NE(refusal(path).find(part), std::string::npos) << path << ": " << refusal(path);
}

TEST(AnswerPath, MembersAndItemsAreFound) {
  EXPECT_EQ(find_in_answer(answer(), "verdict"), "passive");
  EXPECT_EQ(find_in_answer(answer(), "criteria[1].max_stiffness"), 0.0658);
  EXPECT_EQ(find_in_answer(answer(), "criteria.1.max_stiffness"), 0.0658);
  EXPECT_EQ(find_in_answer(answer(), "trace.position[2]"), 0.4);
}

TEST(AnswerPath, AnItemIsFoundByATextANumberOrABooleanInIt) {
  EXPECT_EQ(find_in_answer(answer(), "criteria[name=exact_disk].max_stiffness"), 0.0658);
  EXPECT_EQ(find_in_answer(answer(), "criteria[order=2.5].name"), "exact_disk");
  EXPECT_EQ(find_in_answer(answer(), "criteria[holds=true].name"), "textbook");
}

TEST(AnswerPath, AStarGivesTheListOverAllItems) {
  EXPECT_EQ(find_in_answer(answer(), "criteria[*].max_stiffness"), json({0.5, 0.0658}));
}

TEST(AnswerPath, AListHasALengthAndEnds) {
  EXPECT_EQ(find_in_answer(answer(), "trace.position.#"), 4);
  EXPECT_EQ(find_in_answer(answer(), "empty.#"), 0);
  EXPECT_EQ(find_in_answer(answer(), "trace.position.#min"), -0.2);
  EXPECT_EQ(find_in_answer(answer(), "trace.position.#max"), 0.4);
  EXPECT_EQ(find_in_answer(answer(), "trace.position.#first"), 0.1);
  EXPECT_EQ(find_in_answer(answer(), "trace.position.#last"), -0.2);
  EXPECT_EQ(find_in_answer(answer(), "criteria[*].order.#max"), 2.5);
  EXPECT_EQ(find_in_answer(json::parse(R"({"a": [[1, 7], [null, -3]]})"), "a.#min"), -3);
}

TEST(AnswerPath, WhatIsNotThereIsNamedWithTheNearest) {
  expect_refused("verdit", "did you mean 'verdict'");
  expect_refused("criteria[name=exact_dsk].holds", "did you mean 'exact_disk'");
  expect_refused("criteria[2].holds", "the list has 2 items");
  expect_refused("verdict.length", "found \"passive\"");
  expect_refused("verdict.#max", "is of lists");
  expect_refused("empty.#max", "the list is empty");
  expect_refused("criteria[*].name.#max", "is of lists of numbers");
}

TEST(AnswerPath, APathThatIsNotWrittenAsOneIsRefused) {
  for (const char* path :
       {"", "a..b", ".a", "a.", "a[", "a[x]", "a[=x]", "a[0]b", "a.#mean", "a.#.b"}) {
    EXPECT_THROW(check_answer_path(path), Error) << path;
  }
  for (const char* path : {"a", "a.b[0][1].c", "a[b=c.d].e", "set.damping.0.capacitance"})
    EXPECT_NO_THROW(check_answer_path(path)) << path;
}

}  // namespace
}  // namespace gyrator
