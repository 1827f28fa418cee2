#pragma once

#include "gyrator/core/quantity.hpp"

#include <string_view>

namespace gyrator {

/// A value and the ends of the range that it may lie in, all in SI units; low <= nominal <= high.
struct TolerancedValue {
  double nominal = 0;
  double low = 0;
  double high = 0;

  friend constexpr bool operator==(const TolerancedValue&, const TolerancedValue&) = default;
};

/// Whether a text is a quantity with a tolerance, by the signs that only such a text has.
bool has_tolerance(std::string_view text);

/// Reads a quantity with a tolerance, or a range:
///
///   toleranced = nominal ("±" | "+-" | "+/-") part                  "5 ohm ± 5 %", "5 ohm ± 0.2
///   ohm"
///              | nominal sign part ["/"] sign part                  "2200 uF +20 % -10 %"
///              | quantity "to" quantity                             "0 K to 40 K", nominal the
///              middle | nominal "(" quantity "to" quantity ")"             "20 K (0 K to 40 K)"
///   part       = quantity | number ("%" | "ppm")
///
/// A part in % or ppm is one of the nominal value; any other has the unit of the value, and none
/// where the nominal has none. "+20/-10 %" may share its unit.
/// Throws bad_input, without a place, for anything else: two parts to the same side, a negative
/// part, a part of zero, ends the wrong way round, a nominal outside.
TolerancedValue parse_toleranced_value(std::string_view text, const Unit& expected);

}  // namespace gyrator
