#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace gyrator {

/// Puts numbers and texts one after another into bytes, for messages and journals. Numbers stand
/// as this machine keeps them, texts behind their length (32 bits).
class ByteWriter {
 public:
  template <class T>
  void put(T number) {
    static_assert(std::is_arithmetic_v<T>);
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), &number, sizeof(T));
    bytes_.append(raw.data(), raw.size());
  }
  void put_text(std::string_view text);

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Takes them out again, in the same order. Throws bad_input, without a place, where the bytes end
/// before.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : left_(bytes) {}

  template <class T>
  T take() {
    static_assert(std::is_arithmetic_v<T>);
    T number{};
    std::memcpy(&number, take_raw(sizeof(T)).data(), sizeof(T));
    return number;
  }
  std::string take_text();
  std::string_view left() const { return left_; }

 private:
  std::string_view take_raw(std::size_t size);

  std::string_view left_;
};

}  // namespace gyrator
