#include "gyrator/sweeps/variation.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/rational.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/document_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr std::size_t most_points = 100'000'000;  // of one range, and of a whole sweep

[[noreturn]] void refuse_text(std::string_view text, const std::string& message) {
  throw Error(ErrorCode::bad_input, "--vary", fmt::format("'{}': {}", text, message));
}

// "50", "50log" or "log" behind the last colon.
void read_points(VariationText& variation, std::string_view whole, std::string_view text) {
  variation.logarithmic = text.ends_with("log");
  if (variation.logarithmic) text.remove_suffix(3);
  text = trim(text);
  if (text.empty() && variation.logarithmic) return;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, variation.points);
  if (read.ec != std::errc{} || read.ptr != end || variation.points < 1 ||
      variation.points > most_points) {
    refuse_text(whole, fmt::format("a number of points from 1 to {} must follow the colon, with "
                                   "or without \"log\": FROM..TO:50log",
                                   most_points));
  }
}

// Where the two dots of a range are; those of the folder above ("../a.cir") are none.
std::size_t find_range(std::string_view values) {
  std::size_t at = values.find("..");
  while (at != std::string_view::npos && at + 2 < values.size() &&
         (values[at + 2] == '/' || values[at + 2] == '\\'))
    at = values.find("..", at + 2);
  return at;
}

}  // namespace

VariationText parse_variation(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos || trim(text.substr(0, equals)).empty())
    refuse_text(text, "PATH=FROM..TO:N, PATH=FROM..TO:Nlog or PATH=a,b,c is expected");
  VariationText variation;
  variation.path = trim(text.substr(0, equals));
  variation.place = "--vary " + variation.path;
  std::string_view values = text.substr(equals + 1);
  const std::size_t dots = find_range(values);
  if (dots == std::string_view::npos) {
    for (std::size_t at = 0; at <= values.size();) {
      const std::size_t comma = std::min(values.find(',', at), values.size());
      const std::string_view value = trim(values.substr(at, comma - at));
      if (value.empty()) refuse_text(text, "a value is missing");
      variation.values.emplace_back(value);
      at = comma + 1;
    }
    return variation;
  }
  std::string_view to = values.substr(dots + 2);
  if (const std::size_t colon = to.rfind(':'); colon != std::string_view::npos) {
    read_points(variation, text, to.substr(colon + 1));
    to = to.substr(0, colon);
  }
  if (trim(values.substr(0, dots)).empty() || trim(to).empty())
    refuse_text(text, "an end of the range is missing: FROM..TO:N");
  variation.from = trim(values.substr(0, dots));
  variation.to = trim(to);
  return variation;
}

json describe_variation(const VariationText& text) {
  if (!text.values.empty()) return {{"path", text.path}, {"values", text.values}};
  json entry{{"path", text.path}, {"from", *text.from}, {"to", *text.to}};
  if (text.points > 0) entry["points"] = text.points;
  if (text.logarithmic) entry["scale"] = "log";
  return entry;
}

Variation::Variation(VariationText text, const json& normal, const Member& format)
    : text_(std::move(text)) {
  try {
    found_ = find_member(normal, format, text_.path);
  } catch (const Error& error) {
    refuse(error.message());
  }
  const ValueKind kind = found_.member.kind;
  if (kind == ValueKind::anything) refuse("is no single value and cannot vary");
  for (const json& value : text_.values) {
    values_.push_back(read(value));
    check(values_.back(), normal, format);
  }
  if (!values_.empty()) return;
  if (!is_number()) {
    refuse(fmt::format("has no range: list its values, one after another ({} is expected)",
                       describe_expected(found_.member)));
  }
  read_range();
  check(make_in_range(0), normal, format);
  check(make_in_range(1), normal, format);
}

void Variation::refuse(const std::string& message) const {
  throw Error(ErrorCode::bad_input, text_.place, message);
}

bool Variation::is_number() const {
  const ValueKind kind = found_.member.kind;
  return kind == ValueKind::quantity || kind == ValueKind::time || kind == ValueKind::integer;
}

std::string Variation::unit() const {
  if (!is_number()) return {};
  if (found_.member.kind == ValueKind::time) return std::string(dimension::time.symbol);
  if (found_.member.kind == ValueKind::integer) return "1";
  return std::string(found_.member.unit.symbol);
}

SweepValue Variation::read(const json& value) const {
  try {
    if (is_number()) return read_number(value);
  } catch (const Error& error) {
    refuse(error.message());
  }
  // A choice or a name stands as it is; the reader checks it.
  std::string text = value.is_string() ? value.get<std::string>() : value.dump();
  if (found_.member.kind != ValueKind::boolean) return {text, 0, text};
  if (text != "true" && text != "false")
    refuse(fmt::format("'{}': true or false is expected", text));
  return {text == "true", 0, text};
}

SweepValue Variation::read_number(const json& value) const {
  const Unit& unit = found_.member.kind == ValueKind::quantity ? found_.member.unit
                     : found_.member.kind == ValueKind::time   ? dimension::time
                                                               : dimension::none;
  if (!value.is_number() && !value.is_string()) {
    throw Error(ErrorCode::bad_input, "",
                fmt::format("{}: {} is expected", value.dump(), describe_expected(found_.member)));
  }
  if (found_.member.kind == ValueKind::time) {
    const Rational time = value.is_string() ? parse_time(value.get<std::string>())
                                            : Rational::from_double(value.get<double>());
    return {time.to_string(), time.to_double(), {}};
  }
  const double number =
      value.is_number() ? value.get<double>() : parse_value(value.get<std::string>(), unit);
  if (found_.member.kind != ValueKind::integer) return {number, number, {}};
  if (number != std::floor(number) || std::abs(number) > 0x1p53) {
    throw Error(ErrorCode::bad_input, "",
                fmt::format("{}: a whole number is expected", format_number(number)));
  }
  return {static_cast<std::int64_t>(number), number, {}};
}

void Variation::read_range() {
  // "100..500 uF" would start at 100 farads.
  const auto has_unit = [](const json& value) {
    return value.is_string() && parse_quantity(value.get<std::string>()).dimension.has_value();
  };
  from_ = read(*text_.from).number;
  to_ = read(*text_.to).number;
  const bool from_bare = !has_unit(*text_.from) && from_ != 0;
  const bool to_bare = !has_unit(*text_.to) && to_ != 0;
  if ((from_bare && has_unit(*text_.to)) || (to_bare && has_unit(*text_.from)))
    refuse("only one end of the range has a unit: write it at both");
  if (text_.points == 1 && from_ != to_)
    refuse("a range of 1 point would leave out its end: give the value itself, or 2 points");
  if (text_.logarithmic && !(from_ * to_ > 0)) {
    refuse(fmt::format("{} to {}: a logarithmic range does not reach or pass zero",
                       format_number(from_), format_number(to_)));
  }
}

std::size_t Variation::count_grid_points() const {
  if (!values_.empty()) return values_.size();
  if (text_.points == 0)
    refuse("the number of points is missing: FROM..TO:N (or sample with --sobol or --random)");
  return text_.points;
}

SweepValue Variation::at_grid(std::size_t index) const {
  if (!values_.empty()) return values_[index];
  const double steps = static_cast<double>(text_.points) - 1;
  return make_in_range(steps > 0 ? static_cast<double>(index) / steps : 0);
}

SweepValue Variation::at_share(double share) const {
  if (values_.empty() && found_.member.kind == ValueKind::integer) return make_whole(share);
  if (values_.empty()) return make_in_range(share);
  const auto index = static_cast<std::size_t>(share * static_cast<double>(values_.size()));
  return values_[std::min(index, values_.size() - 1)];
}

SweepValue Variation::make_in_range(double share) const {
  double v =
      text_.logarithmic ? from_ * std::pow(to_ / from_, share) : from_ + (to_ - from_) * share;
  if (share == 0) v = from_;
  if (share == 1) v = to_;
  if (found_.member.kind == ValueKind::quantity) return {v, v, {}};
  if (found_.member.kind == ValueKind::integer)
    return {static_cast<std::int64_t>(std::llround(v)), std::round(v), {}};
  constexpr std::int64_t nanoseconds = 1'000'000'000;
  constexpr double longest = 9e9;  // [s], in 63 bits of nanoseconds
  if (!(std::abs(v) < longest)) refuse(fmt::format("{} s: is too long", format_number(v)));
  const Rational time(std::llround(v * 1e9), nanoseconds);
  return {time.to_string(), time.to_double(), {}};
}

// Rounding to the nearest one would take the ends half as often as the others.
SweepValue Variation::make_whole(double share) const {
  const double step = to_ < from_ ? -1 : 1;
  double v = from_ + step * std::floor(share * (std::abs(to_ - from_) + 1));
  if (text_.logarithmic) {
    const double low = std::min(std::abs(from_), std::abs(to_));
    const double high = std::max(std::abs(from_), std::abs(to_));
    const double way = std::abs(from_) <= std::abs(to_) ? share : 1 - share;
    v = std::copysign(std::floor(low * std::pow((high + 1) / low, way)), from_);
  }
  v = std::clamp(v, std::min(from_, to_), std::max(from_, to_));  // a share next to 1, rounded
  return {static_cast<std::int64_t>(v), v, {}};
}

// By the model's own reader, which knows bounds, choices, and keys that exclude one another.
void Variation::check(const SweepValue& value, json normal, const Member& format) const {
  normal[found_.pointer] = value.given;
  try {
    read_document(normal, format, "");
  } catch (const Error& error) {
    refuse(error.message());
  }
}

}  // namespace gyrator
