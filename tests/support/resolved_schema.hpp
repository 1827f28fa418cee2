#pragma once

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace gyrator {

/// A value of a schema with every reference replaced by its definition, to the last one.
inline nlohmann::ordered_json resolve_references(const nlohmann::ordered_json& value,
                                                 const nlohmann::ordered_json& definitions) {
  const std::string start = "#/$defs/";
  if (value.is_object() && value.contains("$ref")) {
    EXPECT_EQ(value.size(), 1U) << "beside a reference: " << value;
    const auto name = value["$ref"].get<std::string>();
    EXPECT_EQ(name.substr(0, start.size()), start);
    return resolve_references(definitions.at(name.substr(start.size())), definitions);
  }
  nlohmann::ordered_json resolved = value;
  if (value.is_structured()) {
    for (auto& child : resolved) child = resolve_references(child, definitions);
  }
  return resolved;
}

/// A schema with nothing shared: what build_shared_schema() was given.
inline nlohmann::ordered_json resolve_schema(nlohmann::ordered_json schema) {
  const nlohmann::ordered_json definitions =
      schema.value("$defs", nlohmann::ordered_json::object());
  schema.erase("$defs");
  return resolve_references(schema, definitions);
}

}  // namespace gyrator
