#include "gyrator/plots/pretty_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>

namespace gyrator {
namespace {

/// Length of the well-formed UTF-8 character at the front of `text`, 0 where there is none
/// (surrogates and U+FFFE, U+FFFF, which XML forbids, count as none).
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return 0;
  std::uint32_t code = lead & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
    code = code << 6U | (byte(i) & 0x3FU);
  }
  constexpr std::array<std::uint32_t, 5> smallest = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  const bool forbidden = surrogate || code == 0xFFFE || code == 0xFFFF || code > 0x10FFFF;
  return forbidden || code < smallest.at(length) ? 0 : length;
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

}  // namespace

std::string plain_text(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const auto lead = static_cast<unsigned char>(text.front());
    if (length == 0) {
      plain += '?';
    } else if (lead < 0x20 || lead == 0x7F) {
      plain += ' ';
    } else {
      plain += text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return plain;
}

std::string pretty_unit(std::string_view unit) {
  std::string text(unit);
  replace_all(text, ".", "·");
  replace_all(text, "*", "·");
  replace_all(text, "^2", "²");
  replace_all(text, "^3", "³");
  replace_all(text, "ohm", "Ω");
  return text;
}

std::string superscript(int value) {
  constexpr std::array<const char*, 10> digits = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text;
  for (const char c : std::to_string(value))
    text += c == '-' ? "⁻" : digits.at(static_cast<std::size_t>(c - '0'));
  return text;
}

std::string pretty_number(double value, int digits) {
  if (std::isnan(value)) return "–";
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  if (value == 0) return "0";
  // Rounded first: 0.09999 with two digits is 0.1, one power higher.
  const std::string rounded = fmt::format("{:.{}e}", value, digits - 1);
  const auto e = rounded.find('e');
  const int exponent = std::stoi(rounded.substr(e + 1));
  const bool scientific = exponent < -2 || exponent > 5;
  std::string text = scientific ? rounded.substr(0, e)
                                : fmt::format("{:.{}f}", value, std::max(0, digits - 1 - exponent));
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  if (scientific) text += "×10" + superscript(exponent);
  replace_all(text, "-", "−");
  return text;
}

std::string pretty_quantity(double value, std::string_view unit, int digits) {
  if (std::isnan(value) || unit.empty()) return pretty_number(value, digits);
  return pretty_number(value, digits) + " " + pretty_unit(unit);
}

std::string pretty_frequency(double hz, int digits) {
  return hz < 1e-3 ? "→ 0 Hz" : pretty_quantity(hz, "Hz", digits);
}

}  // namespace gyrator
