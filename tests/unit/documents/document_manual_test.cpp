#include "gyrator/documents/document_manual.hpp"

#include "gyrator/documents/document_schema.hpp"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "document_example.hpp"

namespace gyrator {
namespace {

using namespace documents_tests;
using nlohmann::json;

TEST(WriteJsonSchema, has_each_member_with_its_type_bounds_and_default) {
  const json schema = build_json_schema(member::object("", make_device()), "gyrator/device/1");
  EXPECT_EQ(schema["$id"], "gyrator/device/1");
  EXPECT_EQ(schema["additionalProperties"], false);
  EXPECT_EQ(schema["required"], json({"motor"}));
  const json& motor = schema["properties"]["motor"];
  EXPECT_EQ(motor["type"], "object");
  const json& resistance = motor["properties"]["resistance"];
  EXPECT_EQ(resistance["anyOf"][0], json({{"type", "number"}, {"exclusiveMinimum", 0.0}}));
  EXPECT_EQ(resistance["anyOf"][1]["type"], "string");
  EXPECT_EQ(resistance["description"],
            "Of the winding. In ohm, or a text such as \"1.5 ohm\". Must be above 0 ohm.");
  EXPECT_EQ(motor["properties"]["inductance"]["default"], 0);
  EXPECT_EQ(motor["properties"]["torque_constant"]["anyOf"].size(), 3U);  // null too
  EXPECT_EQ(schema["properties"]["order"]["exclusiveMaximum"], 5.0);
  EXPECT_EQ(schema["properties"]["frequencies"]["minItems"], 1);
  // Its rule on keys must not be asked of null.
  EXPECT_EQ(schema["properties"]["limits"]["anyOf"][0]["allOf"].size(), 1U);
  EXPECT_EQ(schema["properties"]["limits"]["anyOf"][1], json({{"type", "null"}}));
}

TEST(WriteJsonSchema, variant_is_one_of_objects_with_a_constant_kind) {
  const json schema = build_json_schema(member::object("", make_device()), "x");
  const json& kinds = schema["properties"]["damping"]["items"]["oneOf"];
  ASSERT_EQ(kinds.size(), 3U);
  EXPECT_EQ(kinds[1]["properties"]["kind"]["const"], "rc");
  EXPECT_EQ(kinds[1]["required"], json({"kind", "resistance", "capacitance"}));
  EXPECT_EQ(kinds[2]["allOf"][0]["oneOf"].size(), 2U);
  const json& sense = schema["properties"]["amplifier"]["oneOf"][0]["properties"]["sense"];
  EXPECT_EQ(sense["enum"], json({"total", "motor"}));
}

TEST(WriteJsonSchema, default_kind_need_not_be_written) {
  const json schema = build_json_schema(make_two_forms(), "x");
  EXPECT_EQ(schema["oneOf"][0]["required"], json({"stiffness"}));
  EXPECT_EQ(schema["oneOf"][1]["required"], json({"motion", "stiffness"}));
}

TEST(WriteManualTable, has_a_row_for_each_key) {
  const std::string manual = write_manual_table(make_device());
  for (const char* part : {
           "### The file\n\nA device | with a motor.\n",
           "| key | unit | default | allowed | meaning |",
           "| `period` | s | `\"1 ms\"` | above 0 s | Of the loop. |",
           "### `motor`\n\nThe winding.",
           "| `resistance` | ohm | required | above 0 ohm | Of the winding. |",
           "| `torque_constant` | N.m/A | none |  | Torque per ampere. |",
           "### `damping[]` with `\"kind\": \"rc\"`",
           "| `sense` |  | `\"total\"` | `total`, `motor` | Where it measures. |",
           "Exactly one of `resistance`, `fraction` must be given.",
           "| `order` |  | `1` | whole number at least 1 and below 5 |  |",
       }) {
    EXPECT_NE(manual.find(part), std::string::npos) << part << "\nis not in\n" << manual;
  }
}

TEST(WriteManualTable, objects_alike_share_a_section) {
  const Member velocity = member::variant(
      "velocity", {{"difference", "Backward.", {member::integer("window").by_default(1)}}});
  const ObjectSpec spec{"",
                        "",
                        {member::object("wall", {"", "A wall.", {velocity}}),
                         member::object("proxy", {"", "A proxy.", {velocity}})}};
  const std::string manual = write_manual_table(spec);
  EXPECT_NE(manual.find("### `wall.velocity`, `proxy.velocity` with `\"kind\": \"difference\"`"),
            std::string::npos)
      << manual;
  EXPECT_EQ(manual.find("Backward."), manual.rfind("Backward."));
}

TEST(WriteManualTable, places_that_differ_in_one_choice_are_written_as_one) {
  const ObjectSpec fast{"fast", "Quick.", {member::integer("order").required()}};
  const Member with_fast = member::variant("filter", {fast, {"none", "Nothing.", {}}});
  const auto law = [&](const char* name) { return ObjectSpec{name, "A law.", {with_fast}}; };
  const Member root = member::variant(
      "",
      {{"rotary",
        "",
        {member::variant("law", {law("a"), law("b"), {"c", "", {}}}), member::boolean("only")}},
       {"linear", "", {member::variant("law", {law("a"), law("b"), {"c", "", {}}})}}},
      "motion");
  const std::string manual = write_manual_table(root);
  EXPECT_NE(manual.find("### `(*).law(a, b).filter` with `\"kind\": \"fast\"`\n\nQuick."),
            std::string::npos)
      << manual;
  EXPECT_EQ(manual.find("Quick."), manual.rfind("Quick."));
}

TEST(WriteManualTable, only_choice_at_a_place_is_named) {
  const ObjectSpec noise{"noise", "Noise.", {member::integer("seed")}};
  const ObjectSpec fast{"fast", "Quick.", {member::object("noise", noise)}};
  const ObjectSpec spec{"", "", {member::variant("filter", {fast})}};
  const std::string manual = write_manual_table(spec);
  EXPECT_NE(manual.find("### `filter(fast).noise`\n"), std::string::npos) << manual;
}

TEST(WriteManualTable, object_that_lacks_a_key_shares_the_section_and_is_told) {
  const Member one = member::integer("one");
  const Member two = member::integer("two");
  const Member extra = member::integer("extra");
  const auto law = [](std::vector<Member> members) {
    return std::vector<ObjectSpec>{{"wall", "A wall.", std::move(members)}};
  };
  const auto manual_of = [&](std::vector<Member> inner) {
    return write_manual_table(ObjectSpec{"",
                                         "",
                                         {member::variant("law", law({one, extra, two})),
                                          member::variant("inner", law(std::move(inner)))}});
  };
  const std::string shared = manual_of({one, two});
  EXPECT_NE(shared.find("### `law`, `inner` with `\"kind\": \"wall\"`\n"), std::string::npos)
      << shared;
  EXPECT_NE(shared.find("\nIn `inner` without `extra`.\n"), std::string::npos) << shared;
  // In another order, with another row, or with little in common: a table of its own.
  for (const auto& inner : std::vector<std::vector<Member>>{
           {two, one}, {one, member::integer("two").required()}, {one, two, extra, one}, {one}}) {
    EXPECT_NE(manual_of(inner).find("### `inner` with"), std::string::npos) << manual_of(inner);
  }
}

TEST(WriteManualTable, bar_inside_a_cell_is_escaped) {
  const ObjectSpec spec{"", "", {member::boolean("a").doc("x | y")}};
  EXPECT_NE(write_manual_table(spec).find("x \\| y"), std::string::npos);
}

}  // namespace
}  // namespace gyrator
