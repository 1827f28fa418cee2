#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// The known name that a slip of the keyboard most likely meant; nothing for an unrelated word.
///
/// Counts insertions, deletions, substitutions and swaps of neighbours; a slip of upper and lower
/// case is free. At most a third of the given word may differ (at least one character, at most
/// three), and of equals the first listed wins. An exact match is returned as it is.
std::optional<std::string> find_nearest_name(std::string_view given,
                                             const std::vector<std::string>& known);

/// "; did you mean 'resistance'?" for the nearest known name, or nothing: the tail of an error.
std::string suggest_name(std::string_view given, const std::vector<std::string>& known);

/// "unknown engine 'cvod': allowed: exact, cvode; did you mean 'cvode'?"
std::string describe_unknown_name(std::string_view what, std::string_view given,
                                  const std::vector<std::string>& known);

/// The parts, one after another with the separator between.
std::string join(const std::vector<std::string>& parts, std::string_view separator = ", ");

/// "1 part", "3 parts"; the plural where adding an s is not enough: "2 boxes".
std::string describe_count(std::size_t count, std::string_view singular,
                           std::string_view plural = {});

/// The first name that the list has twice; nothing where every one is there once.
std::optional<std::string> find_repeated(std::vector<std::string> names);

/// The shortest decimal text that reads back as the same double: "0.1", "2e-05", "-0".
std::string format_number(double value);

/// A text without the blanks (space, tab, line ends) at both ends.
std::string_view trim(std::string_view text);

/// A decimal number as written: `mantissa` × 10^`exponent`, so that scaling by powers of ten can
/// be exact. The mantissa keeps sign and point ("-4.70"); a leading '+' is dropped.
struct DecimalText {
  std::string_view mantissa;
  int exponent = 0;        ///< of the 'e' part; clamped to ±100000, where no double is left
  std::size_t length = 0;  ///< characters read, sign and 'e' part included
};

/// The decimal number at the start of the text: [+-] digits [. digits] [e [+-] digits], with at
/// least one digit. Nothing if none starts there; "nan" and "inf" are none.
std::optional<DecimalText> find_decimal(std::string_view text);

/// Where the first byte stands that is not part of well-formed UTF-8; nothing if all is well.
std::optional<std::size_t> find_invalid_utf8(std::string_view text);

}  // namespace gyrator
