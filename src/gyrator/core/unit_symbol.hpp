#pragma once

#include "gyrator/core/quantity.hpp"

#include <optional>
#include <string_view>

namespace gyrator {

/// A unit in SI: factor × 10^decimal × its base units. The powers of ten are kept apart because
/// they are applied to the decimal text of the number, without rounding.
struct UnitScale {
  Dimension dimension;
  double factor = 1;
  int decimal = 0;
};

/// a · b^power, exponent by exponent.
Dimension multiply(const Dimension& a, const Dimension& b, int power);

/// A unit symbol, with or without prefix: "ohm", "kohm", "min". Whole symbols go before prefix and
/// symbol, so that "m" is metre and "min" is minute.
std::optional<UnitScale> find_unit_symbol(std::string_view text);

/// Reads a unit in plain letters by the grammar at parse_quantity: "mN.m/A", "N.m/(rad/s)".
/// Throws bad_input, with the `whole` text in the message, for anything else.
UnitScale read_unit(std::string_view unit, std::string_view whole);

}  // namespace gyrator
