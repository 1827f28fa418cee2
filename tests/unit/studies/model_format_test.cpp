#include "gyrator/studies/model_format.hpp"

#include "gyrator/documents/document_schema.hpp"

#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/resolved_schema.hpp"

namespace gyrator {
namespace {

using Json = nlohmann::ordered_json;

TEST(ModelFormat, its_schema_says_the_same_as_one_that_shares_nothing) {
  const Json whole = build_json_schema(model_format(), "x");
  const std::string text = write_json_schema(model_format(), "x");
  EXPECT_EQ(resolve_schema(Json::parse(text)).dump(), whole.dump());
  // Laws stand in a law again, and everything in both motions: without sharing it would not be
  // read by anyone.
  EXPECT_LT(text.size(), whole.dump(2).size() / 3);
}

TEST(ModelFormat, no_two_parts_of_its_schema_are_written_twice) {
  const Json shared = Json::parse(write_json_schema(model_format(), "x"));
  std::set<std::string> bodies;
  for (const auto& [name, body] : shared["$defs"].items())
    EXPECT_TRUE(bodies.insert(body.dump()).second) << name;
  EXPECT_GT(bodies.size(), 10U);
}

}  // namespace
}  // namespace gyrator
