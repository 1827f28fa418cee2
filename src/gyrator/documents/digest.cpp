#include "gyrator/documents/digest.hpp"

#include "gyrator/core/error.hpp"

#include <array>
#include <openssl/evp.h>

#include <fmt/core.h>

namespace gyrator {

std::string compute_sha256(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
  unsigned int length = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), hash.data(), &length, EVP_sha256(), nullptr) != 1)
    throw Error(ErrorCode::numerical, "digest", "SHA-256 is not available");
  std::string digits;
  for (unsigned int i = 0; i < length; ++i) digits += fmt::format("{:02x}", hash[i]);
  return digits;
}

}  // namespace gyrator
