#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace gyrator {

/// Nesting deeper than this and files larger than this are refused.
inline constexpr int max_json_depth = 64;
inline constexpr std::size_t max_json_bytes = std::size_t{64} << 20U;

/// The JSON value in a file. Throws bad_input with the path as place, for a file that is missing
/// (with the nearest name beside it), a directory, unreadable, larger than max_json_bytes, and for
/// all that parse_json_text refuses.
nlohmann::json load_json_file(const std::filesystem::path& path);

/// The file's text alone, for parse_json_text. Throws bad_input for what cannot be read.
std::string load_json_text(const std::filesystem::path& path);

/// The JSON value in a text; `name` is the place in errors. Throws bad_input for an empty text,
/// binary or ill-formed UTF-8, a syntax error (line, column, what was expected, the line with a
/// caret), nesting deeper than max_json_depth, a key given twice in one object (JSON pointer), and
/// a number beyond the range of a double. A byte order mark at the start is skipped.
nlohmann::json parse_json_text(std::string_view text, const std::string& name);

}  // namespace gyrator
