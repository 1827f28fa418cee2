#include "gyrator/core/bytes.hpp"

#include "gyrator/core/error.hpp"

namespace gyrator {

void ByteWriter::put_text(std::string_view text) {
  put(static_cast<std::uint32_t>(text.size()));
  bytes_.append(text);
}

std::string ByteReader::take_text() {
  const auto size = take<std::uint32_t>();
  return std::string(take_raw(size));
}

std::string_view ByteReader::take_raw(std::size_t size) {
  if (size > left_.size()) throw Error(ErrorCode::bad_input, "", "ends too early");
  const std::string_view raw = left_.substr(0, size);
  left_.remove_prefix(size);
  return raw;
}

}  // namespace gyrator
