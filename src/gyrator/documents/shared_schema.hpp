#pragma once

#include <map>
#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// The same JSON Schema with every part that it holds more than once written once, in "$defs".
///
/// A part is what a key, an item or an alternative must be. Small ones stay where they are unless
/// `named` has them, and so does a discriminator, by which editors tell alternatives. Where a part
/// stood is `{"$ref": "#/$defs/<name>"}` and nothing beside it, for draft-07 ignores that:
/// putting the definitions back in gives the given schema again, key by key. A name is the end of
/// the path where the part is first used, as long as it takes to be the only one of that name
/// ("thermal", "linear.contact_effects"), or the one in `named`; definitions are in the order of
/// first use.
nlohmann::ordered_json build_shared_schema(
    const nlohmann::ordered_json& schema,
    const std::map<std::string, nlohmann::ordered_json>& named = {});

}  // namespace gyrator
