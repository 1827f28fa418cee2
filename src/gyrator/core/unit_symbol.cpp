#include "gyrator/core/unit_symbol.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace gyrator {

namespace {

constexpr double pi = std::numbers::pi;

struct Symbol {
  std::string_view text;
  UnitScale scale;
  bool takes_prefix = true;
  bool is_alias = false;  // understood, never suggested
};

constexpr Dimension ohm_dimension = dimension::resistance.dimension;

constexpr std::array symbols{
    Symbol{"m", {{.length = 1}}},
    Symbol{"g", {{.mass = 1}, 1, -3}},
    Symbol{"s", {{.time = 1}}},
    Symbol{"A", {{.current = 1}}},
    Symbol{"K", {{.temperature = 1}}},
    Symbol{"N", {dimension::force.dimension}},
    Symbol{"J", {dimension::energy.dimension}},
    Symbol{"W", {dimension::power.dimension}},
    Symbol{"V", {dimension::voltage.dimension}},
    Symbol{"ohm", {ohm_dimension}},
    Symbol{"F", {dimension::capacitance.dimension}},
    Symbol{"H", {dimension::inductance.dimension}},
    Symbol{"Hz", {{.time = -1}}},
    Symbol{"C", {{.time = 1, .current = 1}}},
    Symbol{"rad", {{.angle = 1}}},
    Symbol{"deg", {{.angle = 1}, pi / 180}, false},
    Symbol{"rev", {{.angle = 1}, 2 * pi}, false},
    Symbol{"rpm", {{.time = -1, .angle = 1}, 2 * pi / 60}, false},
    Symbol{"count", {{.count = 1}}, false},
    Symbol{"min", {{.time = 1}, 60}, false},
    Symbol{"%", {{}, 1, -2}, false},
    Symbol{"ppm", {{}, 1, -6}, false},
    Symbol{"counts", {{.count = 1}}, false, true},
    Symbol{"ohms", {ohm_dimension}, true, true},
    Symbol{"Ohm", {ohm_dimension}, true, true},
    Symbol{"Ohms", {ohm_dimension}, true, true},
};

constexpr std::array<std::pair<std::string_view, int>, 8> prefixes{
    {{"p", -12}, {"n", -9}, {"u", -6}, {"m", -3}, {"c", -2}, {"k", 3}, {"M", 6}, {"G", 9}}};

// What other people write for our symbols; none of these is near enough in letters.
constexpr std::array<std::pair<std::string_view, std::string_view>, 9> foreign_words{
    {{"sec", "s"},
     {"volt", "V"},
     {"volts", "V"},
     {"amp", "A"},
     {"amps", "A"},
     {"turn", "rev"},
     {"turns", "rev"},
     {"degree", "deg"},
     {"degrees", "deg"}}};

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '%';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

UnitScale multiply(const UnitScale& a, const UnitScale& b, int power) {
  return {multiply(a.dimension, b.dimension, power), a.factor * std::pow(b.factor, power),
          a.decimal + power * b.decimal};
}

std::optional<UnitScale> find_bare_symbol(std::string_view text) {
  const auto* const symbol = std::find_if(symbols.begin(), symbols.end(),
                                          [text](const Symbol& s) { return s.text == text; });
  if (symbol == symbols.end()) return std::nullopt;
  return symbol->scale;
}

}  // namespace

std::optional<UnitScale> find_unit_symbol(std::string_view text) {
  if (auto scale = find_bare_symbol(text)) return scale;
  for (const Symbol& symbol : symbols) {
    if (!symbol.takes_prefix || !text.ends_with(symbol.text)) continue;
    for (const auto& [prefix, decimal] : prefixes) {
      if (text.size() == prefix.size() + symbol.text.size() && text.starts_with(prefix)) {
        UnitScale scale = symbol.scale;
        scale.decimal += decimal;
        return scale;
      }
    }
  }
  return std::nullopt;
}

namespace {

// "mNm" → "mN.m", "Nms" → "N.m.s": known symbols run together. Only the first may have a prefix,
// unless nothing else fits ("Nmm").
std::optional<std::string> split_symbols(std::string_view text, bool is_first, bool any_prefix) {
  for (std::size_t length = text.size(); length > 0; --length) {
    const std::string piece{text.substr(0, length)};
    if (!(is_first || any_prefix ? find_unit_symbol(piece) : find_bare_symbol(piece))) continue;
    if (length == text.size()) return piece;
    const auto rest = split_symbols(text.substr(length), false, any_prefix);
    if (rest && !rest->starts_with(piece)) return piece + "." + *rest;
  }
  return std::nullopt;
}

std::string suggest_symbol(std::string_view given) {
  if (given == "degC" || given == "degF" || given == "degK") {
    return ": a temperature is written in K (273.15 K is 0 degrees Celsius)";
  }
  if (std::any_of(prefixes.begin(), prefixes.end(),
                  [given](const auto& prefix) { return prefix.first == given; })) {
    return ", a prefix without a symbol behind it";
  }
  // Splitting tries all ways, of which a long word has too many.
  std::optional<std::string> split;
  if (given.size() <= 8) split = split_symbols(given, true, false);
  if (given.size() <= 8 && !split) split = split_symbols(given, true, true);
  const std::string split_hint =
      split ? fmt::format(": symbols are joined with '.'; did you mean '{}'?", *split) : "";
  // A capital N begins newton: "Nm" is no slip for the nanometre.
  if (split && given.starts_with('N')) return split_hint;

  std::vector<std::string> known;
  for (const Symbol& symbol : symbols) {
    if (symbol.is_alias) continue;
    known.emplace_back(symbol.text);
    if (!symbol.takes_prefix) continue;
    for (const auto& [prefix, decimal] : prefixes) {
      known.push_back(std::string(prefix) + std::string(symbol.text));
    }
  }
  // A slip of upper and lower case: the name with the fewest letters changed.
  const std::string* nearest = nullptr;
  constexpr std::size_t no_match = 100;
  std::size_t fewest = no_match;
  for (const std::string& name : known) {
    if (name.size() != given.size()) continue;
    std::size_t changed = 0;
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (name[i] == given[i]) continue;
      changed += (name[i] ^ given[i]) == ('a' ^ 'A') && is_letter(name[i]) ? 1 : no_match;
    }
    if (changed < fewest) {
      fewest = changed;
      nearest = &name;
    }
  }
  if (nearest != nullptr) {
    return fmt::format(": upper and lower case differ; did you mean '{}'?", *nearest);
  }
  for (const auto& [word, symbol] : foreign_words) {
    if (word == given) return fmt::format("; did you mean '{}'?", symbol);
  }
  if (split) return split_hint;
  // Of two letters one is half the word: too little to guess from.
  return given.size() < 3 ? std::string{} : suggest_name(given, known);
}

// Reads a unit expression by recursive descent; `whole` is for the messages.
class UnitReader {
 public:
  UnitReader(std::string_view unit, std::string_view whole) : text_(unit), whole_(whole) {}

  UnitScale read() {
    const UnitScale scale = read_product();
    if (at_ < text_.size()) refuse_here();
    return scale;
  }

 private:
  [[noreturn]] void refuse(const std::string& rule) const {
    throw Error(ErrorCode::bad_input, "", fmt::format("'{}': {}", whole_, rule));
  }

  [[noreturn]] void refuse_here() const {
    if (at_ >= text_.size()) refuse("the unit ends too early: a symbol is expected, such as 'ohm'");
    const char c = text_[at_];
    if (is_digit(c)) refuse(fmt::format("'{}' in the unit: a power is written as in 'm^2'", c));
    if (c == ' ') refuse("a space in the unit: symbols are joined with '.', as in \"5 N.m\"");
    if (c == ',') refuse("a comma: decimals are written with a point, as in \"1.5 ohm\"");
    if (c == ')') refuse("')' in the unit: there is no '(' for it");
    refuse(
        fmt::format("'{}' does not belong into a unit: symbols, '.', '/', '^' and parentheses do",
                    text_.substr(at_)));
  }

  bool accept(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  UnitScale read_product() {
    UnitScale product;
    int sign = accept('/') ? -1 : 1;
    while (true) {
      product = multiply(product, read_factor(), sign);
      if (accept('.') || accept('*')) {
        sign = 1;
      } else if (accept('/')) {
        sign = -1;  // for this one factor
      } else {
        return product;
      }
    }
  }

  UnitScale read_factor() {
    UnitScale scale;
    if (accept('(')) {
      scale = read_product();
      if (!accept(')')) {
        refuse(at_ < text_.size() ? "')' is expected in the unit" : "the unit lacks a ')'");
      }
    } else if (accept('1')) {
      return scale;
    } else {
      const std::size_t start = at_;
      while (at_ < text_.size() && is_letter(text_[at_])) ++at_;
      if (at_ == start) refuse_here();
      const std::string_view symbol = text_.substr(start, at_ - start);
      const auto found = find_unit_symbol(symbol);
      if (!found) refuse(fmt::format("unknown unit '{}'{}", symbol, suggest_symbol(symbol)));
      scale = *found;
    }
    if (accept('^')) scale = multiply({}, scale, read_power());
    // Powers of powers, "((m^9)^9)^9", would soon leave the range of an int.
    const Dimension& d = scale.dimension;
    for (const int power :
         {d.length, d.mass, d.time, d.current, d.temperature, d.angle, d.count, scale.decimal}) {
      if (std::abs(power) > 99) refuse("a power of more than two digits");
    }
    return scale;
  }

  int read_power() {
    const bool negative = accept('-');
    if (at_ >= text_.size() || !is_digit(text_[at_]))
      refuse("a whole number is expected after '^'");
    const int power = text_[at_++] - '0';
    if (at_ < text_.size() && is_digit(text_[at_])) refuse("a power of more than one digit");
    return negative ? -power : power;
  }

  std::string_view text_;
  std::string_view whole_;
  std::size_t at_ = 0;
};

}  // namespace

Dimension multiply(const Dimension& a, const Dimension& b, int power) {
  return {a.length + power * b.length,
          a.mass + power * b.mass,
          a.time + power * b.time,
          a.current + power * b.current,
          a.temperature + power * b.temperature,
          a.angle + power * b.angle,
          a.count + power * b.count};
}

UnitScale read_unit(std::string_view unit, std::string_view whole) {
  return UnitReader(unit, whole).read();
}

}  // namespace gyrator
