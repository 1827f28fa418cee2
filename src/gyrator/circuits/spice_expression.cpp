#include "gyrator/circuits/spice_expression.hpp"

#include "gyrator/circuits/spice_lines.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/core.h>
#include <muParser.h>

namespace gyrator {
namespace {

constexpr std::string_view micro = "\u00B5";
constexpr std::array<std::string_view, 2> ohms{"\u03A9", "\u2126"};  // Greek omega, ohm sign
constexpr std::size_t longest_expression = 4000;

struct Suffix {
  std::string_view text;
  int exponent;
};
// Longer ones first.
constexpr std::array suffixes{Suffix{"meg", 6}, Suffix{"t", 12}, Suffix{"g", 9},    Suffix{"k", 3},
                              Suffix{"m", -3},  Suffix{"u", -6}, Suffix{micro, -6}, Suffix{"n", -9},
                              Suffix{"p", -12}, Suffix{"f", -15}};
constexpr double mil = 25.4e-6;  // a thousandth of an inch, in metres

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

std::size_t skip_digits(std::string_view text, std::size_t at) {
  while (at < text.size() && is_digit(text[at])) ++at;
  return at;
}

std::size_t skip_unit(std::string_view text, std::size_t at) {
  while (at < text.size()) {
    if (is_letter(text[at])) {
      ++at;
    } else if (text.substr(at).starts_with(micro) || text.substr(at).starts_with(ohms[0])) {
      at += 2;
    } else if (text.substr(at).starts_with(ohms[1])) {
      at += 3;
    } else {
      break;
    }
  }
  return at;
}

double pow_of(double base, double exponent) {
  return std::pow(base, exponent);
}
double choose(double condition, double yes, double no) {
  return condition != 0 ? yes : no;
}
double floor_of(double x) {
  return std::floor(x);
}
double ceil_of(double x) {
  return std::ceil(x);
}
double truncate(double x) {
  return std::trunc(x);
}
double sign_of(double x) {
  return x > 0 ? 1 : (x < 0 ? -1 : 0);
}

mu::Parser make_parser() {
  mu::Parser parser;
  parser.DefineFun("pow", pow_of);
  parser.DefineFun("if", choose);
  parser.DefineFun("floor", floor_of);
  parser.DefineFun("ceil", ceil_of);
  parser.DefineFun("int", truncate);
  parser.DefineFun("sgn", sign_of);
  return parser;
}

std::string_view without_braces(std::string_view text) {
  text = trim(text);
  const bool braced = text.size() >= 2 && ((text.front() == '{' && text.back() == '}') ||
                                           (text.front() == '\'' && text.back() == '\''));
  return braced ? trim(text.substr(1, text.size() - 2)) : text;
}

// Rewrites an expression for muParser, which knows neither suffixes nor SPICE's names: every
// number and parameter becomes a plain decimal number.
class Translation {
 public:
  Translation(std::string_view text, const std::string& place, const SpiceLookup& parameter,
              const mu::Parser& parser)
      : text_(text), place_(place), parameter_(parameter), parser_(parser) {}

  std::string translate() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (is_digit(c) || c == '.') {
        translate_number();
      } else if (is_letter(c) || c == '_') {
        translate_name();
      } else if (text_.substr(at_).starts_with("**")) {
        result_ += '^';
        at_ += 2;
      } else if (std::string_view("+-*/^(),<>=!&|?: \t").find(c) != std::string_view::npos) {
        result_ += c;
        ++at_;
      } else {
        const bool multibyte = static_cast<unsigned char>(c) >= 0x80;
        refuse(multibyte ? "a character that is not ASCII" : fmt::format("'{}'", c));
      }
    }
    return result_;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(ErrorCode::bad_input, place_,
                fmt::format("expression '{}': unexpected {}", text_, what));
  }

  void append(double value) {
    // The blanks keep a sign apart from the operator before it.
    result_ += " (" + format_number(value) + ") ";
  }

  void translate_number() {
    const auto number = find_spice_number(text_.substr(at_));
    if (!number) refuse(fmt::format("'{}'", text_.substr(at_)));
    append(number->value);
    at_ += number->length;
  }

  void translate_name() {
    const std::size_t start = at_;
    while (at_ < text_.size() &&
           (is_letter(text_[at_]) || is_digit(text_[at_]) || text_[at_] == '_')) {
      ++at_;
    }
    const std::string name = lower_spice(text_.substr(start, at_ - start));
    const std::size_t next = text_.find_first_not_of(" \t", at_);
    if (next == std::string_view::npos || text_[next] != '(') {
      append(parameter_(name));
      return;
    }
    if (!parser_.GetFunDef().contains(name)) {
      std::vector<std::string> known;
      for (const auto& [function, callback] : parser_.GetFunDef()) known.push_back(function);
      throw Error(ErrorCode::bad_input, place_,
                  fmt::format("expression '{}': {}", text_,
                              describe_unknown_name("function", name, known)));
    }
    result_ += name;
  }

  std::string_view text_;
  const std::string& place_;
  const SpiceLookup& parameter_;
  const mu::Parser& parser_;
  std::size_t at_ = 0;
  std::string result_;
};

}  // namespace

std::optional<SpiceNumber> find_spice_number(std::string_view text) {
  std::size_t at = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
  const std::size_t whole_end = skip_digits(text, at);
  std::size_t digits = whole_end - at;
  at = whole_end;
  const bool has_point = at < text.size() && text[at] == '.';
  if (has_point) {
    at = skip_digits(text, at + 1);
    digits += at - whole_end - 1;
  }
  if (digits == 0) return std::nullopt;
  std::string mantissa(text.substr(0, at));
  if (mantissa[0] == '+') mantissa.erase(0, 1);

  int exponent = 0;
  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    const std::size_t sign = at + 1 < text.size() && (text[at + 1] == '+' || text[at + 1] == '-');
    const std::size_t end = skip_digits(text, at + 1 + sign);
    if (end > at + 1 + sign) {
      const char* from = text.data() + at + 1 + (text[at + 1] == '+' ? 1 : 0);
      if (std::from_chars(from, text.data() + end, exponent).ec != std::errc{}) return std::nullopt;
      if (std::abs(exponent) > 10000) return std::nullopt;
      at = end;
    }
  }

  double factor = 1;
  const std::string tail = lower_spice(text.substr(at, 4));
  const auto* suffix = std::find_if(suffixes.begin(), suffixes.end(),
                                    [&](const Suffix& s) { return tail.starts_with(s.text); });
  if (tail.starts_with("mil")) {
    factor = mil;
    at += 3;
  } else if (suffix != suffixes.end()) {
    exponent += suffix->exponent;
    at += suffix->text.size();
    const std::size_t fraction = skip_digits(text, at);
    if (fraction > at && !has_point) {
      mantissa.append(".").append(text.substr(at, fraction - at));
      at = fraction;
    }
  }
  at = skip_unit(text, at);

  const std::string decimal = fmt::format("{}e{}", mantissa, exponent);
  double value = 0;
  const auto read = std::from_chars(decimal.data(), decimal.data() + decimal.size(), value);
  if (read.ec != std::errc{} || !std::isfinite(value * factor)) return std::nullopt;
  return SpiceNumber{value * factor, at};
}

double evaluate_spice_expression(std::string_view text, const std::string& place,
                                 const SpiceLookup& parameter) {
  const std::string_view inner = without_braces(text);
  if (inner.size() > longest_expression) {
    throw Error(ErrorCode::bad_input, place,
                fmt::format("an expression of {} characters: at most {}", inner.size(),
                            longest_expression));
  }
  const auto lookup = [&](const std::string& name) {
    return name == "pi" ? std::numbers::pi : parameter(name);
  };
  // A plain number needs no parser.
  const auto number = find_spice_number(inner);
  if (number && number->length == inner.size()) return number->value;
  double value = 0;
  try {
    mu::Parser parser = make_parser();
    parser.SetExpr(Translation(inner, place, lookup, parser).translate());
    value = parser.Eval();
    if (parser.GetNumResults() != 1) {
      throw Error(ErrorCode::bad_input, place,
                  fmt::format("expression '{}': a comma outside of a function", inner));
    }
  } catch (const mu::Parser::exception_type&) {
    throw Error(ErrorCode::bad_input, place,
                fmt::format("expression '{}': not a formula of numbers, parameters, operators "
                            "+ - * / ^ and functions",
                            inner));
  }
  if (std::isfinite(value)) return value;
  throw Error(ErrorCode::bad_input, place,
              fmt::format("expression '{}' has the value {}: must be finite", inner, value));
}

}  // namespace gyrator
