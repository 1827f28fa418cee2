#include "gyrator/documents/document_schema.hpp"

#include "gyrator/core/text.hpp"
#include "gyrator/documents/shared_schema.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

#include <fmt/core.h>

namespace gyrator {

namespace {

// In the order of insertion, so that the schema reads like the table it comes from.
using Json = nlohmann::ordered_json;

// The start of a quantity: enough for an editor to tell a slip from a unit that it cannot know.
constexpr const char* quantity_pattern = R"(^\s*[+-]?(\d+(\.\d+)?|\.\d+)([eE][+-]?\d+)?)";

Json write_value(const Member& member);

Json write_quantity_text() {
  return {{"type", "string"}, {"pattern", quantity_pattern}};
}

void add_bounds(Json& schema, const Member& member) {
  if (member.low)
    schema[member.low->exclusive ? "exclusiveMinimum" : "minimum"] = member.low->value;
  if (member.high) {
    schema[member.high->exclusive ? "exclusiveMaximum" : "maximum"] = member.high->value;
  }
}

std::string describe(const Member& member) {
  std::vector<std::string> sentences;
  if (!member.meaning.empty()) sentences.push_back(member.meaning);
  const bool is_quantity = member.kind == ValueKind::quantity || member.kind == ValueKind::time;
  if (is_quantity) {
    std::string unit(member.unit.symbol);
    sentences.push_back(
        (unit == "1" ? "A number, or a text such as \"" : "In " + unit + ", or a text such as \"") +
        std::string(member.unit.example) + "\".");
    if (member.takes_tolerance) {
      sentences.push_back(fmt::format("With a tolerance: \"{} ± 5 %\".",
                                      unit == "1" ? "0.05" : member.unit.example));
    }
  }
  if (const std::string range = describe_range(member); !range.empty()) {
    sentences.push_back("Must be " + range + ".");
  }
  return join(sentences, " ");
}

void allow_null(Json& schema) {
  // Rules on keys hold emptily for null, and more than one of oneOf would: keep them from it.
  if (schema.contains("allOf")) {
    Json object = std::move(schema);
    schema = {{"anyOf", Json::array({std::move(object)})}};
  }
  for (const char* key : {"anyOf", "oneOf"}) {
    if (schema.contains(key)) return schema[key].push_back({{"type", "null"}});
  }
  if (schema.contains("enum")) return schema["enum"].push_back(nullptr);
  if (schema.contains("type")) schema["type"] = Json::array({schema["type"], "null"});
}

Json write_member(const Member& member) {
  Json schema = write_value(member);
  if (member.is_list) {
    Json items = std::move(schema);
    schema = {{"type", "array"}, {"items", std::move(items)}};
    if (member.min_items > 0) schema["minItems"] = member.min_items;
    if (member.max_items) schema["maxItems"] = *member.max_items;
  }
  if (member.is_nullable()) allow_null(schema);
  if (const std::string text = describe(member); !text.empty()) schema["description"] = text;
  if (member.fallback) schema["default"] = Json::parse(member.fallback->dump());
  return schema;
}

// "The key is there and not null", which is what the reader counts as given.
Json write_given(const std::string& key) {
  return {{"required", Json::array({key})}, {"properties", {{key, {{"not", {{"type", "null"}}}}}}}};
}

Json write_group(const std::vector<std::string>& group, bool needs_one) {
  Json given = Json::array();
  for (const std::string& key : group) given.push_back(write_given(key));
  Json ways = given;
  if (!needs_one) ways.push_back({{"not", {{"anyOf", given}}}});
  return {{"oneOf", ways}};
}

// `owner` is the member whose value this is; a variant's objects carry its discriminator.
Json write_object(const ObjectSpec& spec, const Member& owner) {
  Json schema = {{"type", "object"}};
  if (!spec.meaning.empty()) schema["description"] = spec.meaning;
  Json properties = Json::object();
  Json required = Json::array();
  if (owner.kind == ValueKind::variant) {
    properties[owner.discriminator] = {{"const", spec.name}, {"description", spec.meaning}};
    if (spec.name != owner.default_kind) required.push_back(owner.discriminator);
  }
  for (const Member& member : spec.members) {
    properties[member.name] = write_member(member);
    if (member.is_required) required.push_back(member.name);
  }
  schema["properties"] = std::move(properties);
  if (!required.empty()) schema["required"] = std::move(required);
  schema["additionalProperties"] = false;
  for (const auto& group : spec.exactly_one) schema["allOf"].push_back(write_group(group, true));
  for (const auto& group : spec.at_most_one) schema["allOf"].push_back(write_group(group, false));
  return schema;
}

Json write_value(const Member& member) {
  switch (member.kind) {
    case ValueKind::quantity:
    case ValueKind::time: {
      Json number = {{"type", "number"}};
      add_bounds(number, member);
      return {{"anyOf", Json::array({number, write_quantity_text()})}};
    }
    case ValueKind::integer: {
      Json number = {{"type", "integer"}};
      add_bounds(number, member);
      return number;
    }
    case ValueKind::boolean:
      return {{"type", "boolean"}};
    case ValueKind::text:
      return {{"type", "string"}};
    case ValueKind::choice:
      return {{"enum", member.names}};
    case ValueKind::object:
      return write_object(member.objects.front(), member);
    case ValueKind::variant: {
      Json alternatives = Json::array();
      for (const ObjectSpec& spec : member.objects)
        alternatives.push_back(write_object(spec, member));
      return {{"oneOf", alternatives}};
    }
    case ValueKind::anything:
      return Json::object();
  }
  return {};
}

constexpr std::size_t line_width = 100;

// The JSON on one line where it fits, which keeps what belongs together on the screen; else every
// key or item on lines of its own. `width` is what is left of the line.
std::string write_lines(const Json& value, std::size_t indent, std::size_t width) {
  if (!value.is_structured()) return value.dump();
  std::vector<std::string> line;
  std::vector<std::string> block;
  for (const auto& [key, child] : value.items()) {
    const std::string name = value.is_object() ? Json(key).dump() + ": " : "";
    line.push_back(name + write_lines(child, 0, std::string::npos));
    if (width == std::string::npos) continue;
    const std::size_t used = std::min(line_width, indent + 2 + name.size());
    block.push_back(name + write_lines(child, indent + 2, line_width - used));
  }
  const char open = value.is_object() ? '{' : '[';
  const char close = value.is_object() ? '}' : ']';
  const std::string whole = open + join(line, ", ") + close;
  if (whole.size() <= width) return whole;
  const std::string start = "\n" + std::string(indent + 2, ' ');
  return open + start + join(block, "," + start) + "\n" + std::string(indent, ' ') + close;
}

}  // namespace

std::string write_json_schema(const ObjectSpec& spec, const std::string& id) {
  return write_json_schema(member::object("", spec), id);
}

std::string write_json_schema(const Member& root, const std::string& id) {
  const std::map<std::string, Json> named = {{"quantity", write_quantity_text()}};
  return write_lines(build_shared_schema(build_json_schema(root, id), named), 0, line_width) + "\n";
}

nlohmann::ordered_json build_json_schema(const Member& root, const std::string& id) {
  // Draft-07 is what VS Code validates and completes in full; under 2020-12 it long gave only a
  // warning and completed little below the root. Nothing here needs the newer draft.
  Json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"}, {"$id", id}};
  Json body = write_value(root);
  const Json editor_key = {{"type", "string"}, {"description", "The schema an editor checks by."}};
  if (body.contains("oneOf")) {
    for (Json& alternative : body["oneOf"]) alternative["properties"]["$schema"] = editor_key;
  } else {
    body["properties"]["$schema"] = editor_key;
  }
  schema.update(body);
  return schema;
}

}  // namespace gyrator
