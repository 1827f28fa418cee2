#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace gyrator {

/// The value that a path names in a command's JSON answer:
///
///   path = step { "." step }
///   step = key { "[" number "]" | "[" key "=" text "]" | "[*]" } | number
///        | "#" | "#min" | "#max" | "#first" | "#last"
///
/// "criteria[name=exact_disk].max_stiffness", "poses[*].name", "damping.#" (length of the list),
/// "energy_trace.stored.#max". `[key=text]` is the first item whose member is that text, number
/// or boolean; `[*]` gives the list of what the rest of the path names in each item. "#…", at the
/// end, is of the list before it: its length, a number of it; null items are left out of #min and
/// #max, which look through lists of lists.
/// Throws bad_input, without a place, for a path that is not written so, and for what the answer
/// does not have, with the nearest name.
nlohmann::json find_in_answer(const nlohmann::json& answer, std::string_view path);

/// Throws what find_in_answer would for a path that is not written as above. "set.PATH" passes too:
/// a varied value of the model.
void check_answer_path(std::string_view path);

}  // namespace gyrator
