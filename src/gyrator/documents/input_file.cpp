#include "gyrator/documents/input_file.hpp"

#include "gyrator/core/error.hpp"

#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

namespace gyrator {

namespace fs = std::filesystem;

std::string read_text_file(const fs::path& path) {
  std::error_code ignored;
  // A stream opens a folder and fails with the first byte.
  if (fs::is_directory(path, ignored))
    throw Error(ErrorCode::bad_input, path.string(), "is a folder: a file is expected");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw Error(ErrorCode::bad_input, path.string(),
                "cannot be read: " + std::generic_category().message(errno));
  }
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string read_text_file_if_any(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored) ? read_text_file(path) : std::string();
}

}  // namespace gyrator
