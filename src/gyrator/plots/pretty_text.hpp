#pragma once

#include <string>
#include <string_view>

namespace gyrator {

/// `text` with control characters as spaces and bytes that are no UTF-8 as '?': fit to be put
/// into an SVG or HTML page once its markup characters are escaped.
std::string plain_text(std::string_view text);

/// A unit as one prints it: "N.m.s/rad" → "N·m·s/rad", "kg.m^2" → "kg·m²", "ohm" → "Ω".
std::string pretty_unit(std::string_view unit);

/// A number to `digits` significant digits for people: "0.4", "3.6×10⁻³", "∞"; "–" for no number.
std::string pretty_number(double value, int digits = 4);

/// pretty_number and pretty_unit with a space between; only "–" where there is no number.
std::string pretty_quantity(double value, std::string_view unit, int digits = 4);

/// A frequency; below 1 mHz, far below the slowest pole, it stands for the limit: "→ 0 Hz".
std::string pretty_frequency(double hz, int digits = 4);

/// A whole number as superscript: −3 → "⁻³".
std::string superscript(int value);

}  // namespace gyrator
