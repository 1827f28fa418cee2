#include "gyrator/documents/shared_schema.hpp"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/resolved_schema.hpp"

namespace gyrator {
namespace {

using Json = nlohmann::ordered_json;

Json make_part(const std::string& sentence) {
  return {{"type", "number"}, {"description", sentence + std::string(120, '.')}};
}

Json make_object(const Json& properties) {
  return {{"type", "object"}, {"properties", properties}};
}

TEST(BuildSharedSchema, part_used_twice_is_written_once_and_resolves_to_the_same) {
  const Json inner = make_object({{"gain", make_part("A gain")}});
  const Json schema =
      make_object({{"left", inner}, {"right", inner}, {"flag", {{"type", "boolean"}}}});
  const Json shared = build_shared_schema(schema);
  EXPECT_EQ(shared["properties"]["left"], Json({{"$ref", "#/$defs/left"}}));
  EXPECT_EQ(shared["properties"]["right"], Json({{"$ref", "#/$defs/left"}}));
  // The gain is used once, in the definition.
  EXPECT_EQ(shared["$defs"], Json({{"left", inner}}));
  EXPECT_EQ(resolve_schema(shared).dump(), schema.dump());
}

TEST(BuildSharedSchema, what_is_used_inside_and_outside_of_a_shared_part_is_shared_too) {
  const Json gain = make_part("A gain");
  const Json inner = make_object({{"gain", gain}});
  const Json schema = make_object({{"left", inner}, {"right", inner}, {"own", gain}});
  const Json shared = build_shared_schema(schema);
  EXPECT_EQ(shared["$defs"].size(), 2U);
  EXPECT_EQ(shared["$defs"]["left"]["properties"]["gain"], Json({{"$ref", "#/$defs/gain"}}));
  EXPECT_EQ(resolve_schema(shared).dump(), schema.dump());
}

TEST(BuildSharedSchema, nothing_is_shared_where_all_differs_or_is_small) {
  const Json schema = make_object({{"a", make_part("A")},
                                   {"b", make_part("B")},
                                   {"c", {{"type", "null"}}},
                                   {"d", {{"type", "null"}}}});
  EXPECT_EQ(build_shared_schema(schema), schema);
}

TEST(BuildSharedSchema, parts_of_one_name_are_told_apart_by_their_paths) {
  // Of three parts "gain" one is in both forms, the others in one each.
  const auto make_form = [](const std::string& name) {
    const Json own = make_part("Of " + name);
    return make_object(
        {{"motion", {{"const", name}}},
         {"a", make_object({{"gain", own}})},
         {"b", make_object({{"gain", own}, {"x", {{"type", "null"}}}})},
         {"c", make_object({{"gain", make_part("Of both")}, {"of", {{"const", name}}}})}});
  };
  const Json schema = {{"oneOf", {make_form("rotary"), make_form("linear")}}};
  const Json shared = build_shared_schema(schema);
  const Json& forms = shared["oneOf"];
  const auto gain = [&](int form, const char* key) {
    return forms[form]["properties"][key]["properties"]["gain"]["$ref"];
  };
  EXPECT_EQ(gain(0, "a"), "#/$defs/rotary.gain");
  EXPECT_EQ(gain(0, "b"), "#/$defs/rotary.gain");
  EXPECT_EQ(gain(1, "b"), "#/$defs/linear.gain");
  EXPECT_EQ(gain(0, "c"), "#/$defs/c.gain");
  EXPECT_EQ(gain(1, "c"), "#/$defs/c.gain");
  EXPECT_EQ(resolve_schema(shared).dump(), schema.dump());
}

TEST(BuildSharedSchema, alternatives_are_named_by_key_and_kind_and_keep_their_discriminator) {
  const auto make_kind = [](const std::string& kind) {
    return make_object({{"kind", {{"const", kind}, {"description", std::string(200, 'x')}}}});
  };
  const Json list = {{"type", "array"}, {"items", {{"oneOf", {make_kind("rc"), make_kind("r")}}}}};
  Json other = list;
  other["minItems"] = 1;
  other["items"]["oneOf"].push_back(make_kind("l"));
  const Json schema = make_object({{"damping", list}, {"brakes", other}});
  const Json shared = build_shared_schema(schema);
  EXPECT_EQ(shared["$defs"],
            Json({{"damping.rc", make_kind("rc")}, {"damping.r", make_kind("r")}}));
  EXPECT_EQ(resolve_schema(shared).dump(), schema.dump());
}

TEST(BuildSharedSchema, discriminator_is_not_shared_between_objects_of_one_kind) {
  const Json kind = {{"const", "rc"}, {"description", std::string(200, 'x')}};
  const Json schema = make_object(
      {{"a", {{"oneOf", {make_object({{"kind", kind}, {"more", {{"type", "null"}}}})}}}},
       {"b", {{"oneOf", {make_object({{"kind", kind}})}}}}});
  EXPECT_EQ(build_shared_schema(schema), schema);
}

TEST(BuildSharedSchema, given_name_holds_for_a_small_part_and_for_no_other) {
  const Json text = {{"type", "string"}};
  const Json big = make_part("Big");
  const Json schema =
      make_object({{"a", text}, {"b", text}, {"text", big}, {"c", make_object({{"text", big}})}});
  const Json shared = build_shared_schema(schema, {{"text", text}});
  EXPECT_EQ(shared["properties"]["b"], Json({{"$ref", "#/$defs/text"}}));
  EXPECT_EQ(shared["$defs"]["text"], text);
  EXPECT_EQ(shared["$defs"].size(), 2U);
  EXPECT_EQ(resolve_schema(shared).dump(), schema.dump());
}

}  // namespace
}  // namespace gyrator
