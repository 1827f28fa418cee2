#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace gyrator {

/// A number at the start of a text, and how many characters belong to it.
struct SpiceNumber {
  double value = 0;
  std::size_t length = 0;
};

/// The number at the start of a text, with SPICE's suffix in any case:
///   t 1e12, g 1e9, meg 1e6, k 1e3, m 1e-3, u µ 1e-6, n 1e-9, p 1e-12, f 1e-15, mil 25.4e-6
///
/// Letters behind are a unit and ignored ("2.2kOhm", "10uF"); other letters than these are a unit
/// alone ("5V"). As in SPICE "1M" is a milli and "1F" a femto. A suffix may stand for the decimal
/// point, as LTspice has it: "4K7". Powers of ten are applied to the decimal text, so that "10u" is
/// the same double as 10e-6. Nothing where no number starts, or none that a double can hold.
std::optional<SpiceNumber> find_spice_number(std::string_view text);

/// The value of a parameter, by its name in lower case; throws for an unknown one.
using SpiceLookup = std::function<double(const std::string& name)>;

/// The value of an expression: "{2*pi*f0}", "'r1+r2'", "4.7k" or the same without braces.
///
/// Numbers as above, + - * / ^ ** (power, to the right), comparisons, && || ?:, pi, parameters, and
/// functions: sin cos tan asin acos atan atan2 sinh … exp ln log (natural) log2 log10 sqrt abs sign
/// min max sum avg rint, and pow if floor ceil int sgn. Throws bad_input at `place`, with the text,
/// for anything else and for a result that is not finite.
double evaluate_spice_expression(std::string_view text, const std::string& place,
                                 const SpiceLookup& parameter);

}  // namespace gyrator
