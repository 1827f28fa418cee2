#include "gyrator/core/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace gyrator {

namespace {

char to_lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// Optimal string alignment: the edits of Levenshtein and the swap of two neighbours, each of
// cost 1.
std::size_t compute_edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before_last.swap(last);
    last.swap(row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = to_lower(a[i - 1]) == to_lower(b[j - 1]);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && to_lower(a[i - 1]) == to_lower(b[j - 2]) &&
                           to_lower(a[i - 2]) == to_lower(b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row[b.size()];
}

}  // namespace

std::optional<std::string> find_nearest_name(std::string_view given,
                                             const std::vector<std::string>& known) {
  // Long words cannot be near a name, and would cost time in proportion to their length.
  if (given.empty() || given.size() > 100) return std::nullopt;
  const std::size_t limit = std::clamp<std::size_t>(given.size() / 3, 1, 3);
  const std::string* nearest = nullptr;
  std::size_t least = limit + 1;
  for (const std::string& name : known) {
    if (name == given) return name;
    const std::size_t distance = compute_edit_distance(given, name);
    // Of a name as short as the distance nothing would be left: 'x' is not a slip for 'm'.
    if (distance < least && distance < name.size()) {
      least = distance;
      nearest = &name;
    }
  }
  if (nearest == nullptr) return std::nullopt;
  return *nearest;
}

std::string suggest_name(std::string_view given, const std::vector<std::string>& known) {
  const auto name = find_nearest_name(given, known);
  return name ? "; did you mean '" + *name + "'?" : std::string{};
}

std::string describe_unknown_name(std::string_view what, std::string_view given,
                                  const std::vector<std::string>& known) {
  std::string text = "unknown ";
  text.append(what).append(" '").append(given).append("': allowed: ");
  return text + join(known) + suggest_name(given, known);
}

std::string join(const std::vector<std::string>& parts, std::string_view separator) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) text += separator;
    text += parts[i];
  }
  return text;
}

std::string describe_count(std::size_t count, std::string_view singular, std::string_view plural) {
  std::string text = std::to_string(count) + " ";
  if (count == 1) return text.append(singular);
  if (plural.empty()) return text.append(singular).append("s");
  return text.append(plural);
}

std::optional<std::string> find_repeated(std::vector<std::string> names) {
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice == names.end()) return std::nullopt;
  return *twice;
}

std::string format_number(double value) {
  std::array<char, 32> buffer{};  // the longest double, -2.2250738585072014e-308, has 24 characters
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string_view trim(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::optional<DecimalText> find_decimal(std::string_view text) {
  constexpr int exponent_limit = 100000;
  std::size_t at = 0;
  const auto skip_digits = [&text](std::size_t from) {
    while (from < text.size() && is_digit(text[from])) ++from;
    return from;
  };

  if (at < text.size() && (text[at] == '+' || text[at] == '-')) ++at;
  const std::size_t start = !text.empty() && text[0] == '+' ? 1 : 0;
  const std::size_t whole_end = skip_digits(at);
  std::size_t digits = whole_end - at;
  at = whole_end;
  if (at < text.size() && text[at] == '.') {
    const std::size_t fraction_end = skip_digits(at + 1);
    // Without a digit behind it the point is a unit's, as in "5.m".
    if (fraction_end > at + 1) {
      digits += fraction_end - at - 1;
      at = fraction_end;
    }
  }
  if (digits == 0) return std::nullopt;

  DecimalText decimal{text.substr(start, at - start), 0, at};
  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    std::size_t from = at + 1;
    const bool negative = from < text.size() && text[from] == '-';
    if (from < text.size() && (text[from] == '-' || text[from] == '+')) ++from;
    const std::size_t end = skip_digits(from);
    for (std::size_t i = from; i < end; ++i) {
      decimal.exponent = std::min(10 * decimal.exponent + (text[i] - '0'), exponent_limit);
    }
    if (negative) decimal.exponent = -decimal.exponent;
    if (end > from) decimal.length = end;
  }
  return decimal;
}

std::optional<std::size_t> find_invalid_utf8(std::string_view text) {
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  std::size_t at = 0;
  while (at < text.size()) {
    const unsigned lead = byte(at);
    std::size_t length = 1;
    char32_t smallest = 0;  // that needs this length: an overlong form is ill-formed
    char32_t code = lead;
    if (lead >= 0x80) {
      if (lead >= 0xC2 && lead < 0xE0) {
        length = 2, smallest = 0x80, code = lead & 0x1FU;
      } else if (lead >= 0xE0 && lead < 0xF0) {
        length = 3, smallest = 0x800, code = lead & 0x0FU;
      } else if (lead >= 0xF0 && lead < 0xF5) {
        length = 4, smallest = 0x10000, code = lead & 0x07U;
      } else {
        return at;
      }
    }
    if (at + length > text.size()) return at;
    for (std::size_t i = 1; i < length; ++i) {
      if ((byte(at + i) & 0xC0U) != 0x80U) return at;
      code = (code << 6U) | (byte(at + i) & 0x3FU);
    }
    const bool surrogate = code >= 0xD800 && code < 0xE000;
    if (code < smallest || code > 0x10FFFF || surrogate) return at;
    at += length;
  }
  return std::nullopt;
}

}  // namespace gyrator
