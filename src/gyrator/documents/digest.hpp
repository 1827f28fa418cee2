#pragma once

#include <string>
#include <string_view>

namespace gyrator {

/// SHA-256 of the bytes as 64 hexadecimal digits. Throws numerical where the system's OpenSSL has
/// none.
std::string compute_sha256(std::string_view bytes);

}  // namespace gyrator
