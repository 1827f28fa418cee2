#pragma once

#include <filesystem>
#include <string>

namespace gyrator {

/// The bytes of a file. Throws bad_input, with the path as place, for one that is missing, a folder
/// or unreadable.
std::string read_text_file(const std::filesystem::path& path);

/// The same, and an empty text where there is no such file.
std::string read_text_file_if_any(const std::filesystem::path& path);

}  // namespace gyrator
