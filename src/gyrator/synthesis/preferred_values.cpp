#include "gyrator/synthesis/preferred_values.hpp"

#include <cmath>
#include <cstdlib>

#include <fmt/core.h>

namespace gyrator {
namespace {

// A limit of the range that is a value of the series belongs to it, whatever its last digit.
constexpr double rounding = 1e-12;

double read_decimal(long mantissa, int exponent) {
  return std::strtod(fmt::format("{}e{}", mantissa, exponent).c_str(), nullptr);
}

// `decade` as whole numbers of `digits` digits.
std::vector<double> list_values(const std::vector<long>& decade, int digits, double low,
                                double high) {
  std::vector<double> values;
  const int first = static_cast<int>(std::floor(std::log10(low))) - 1;
  const int last = static_cast<int>(std::ceil(std::log10(high))) + 1;
  for (int exponent = first; exponent <= last; ++exponent) {
    for (const long mantissa : decade) {
      const double value = read_decimal(mantissa, exponent - digits + 1);
      if (value >= low * (1 - rounding) && value <= high * (1 + rounding)) values.push_back(value);
    }
  }
  return values;
}

// E12 and E24 are older than the rule and differ from it; E96 follows it, 100 * 10^(k/96).
const std::vector<long>& list_mantissas(PreferredSeries series) {
  static const std::vector<long> e12{10, 12, 15, 18, 22, 27, 33, 39, 47, 56, 68, 82};
  static const std::vector<long> e24{10, 11, 12, 13, 15, 16, 18, 20, 22, 24, 27, 30,
                                     33, 36, 39, 43, 47, 51, 56, 62, 68, 75, 82, 91};
  static const std::vector<long> e96 = [] {
    std::vector<long> values;
    for (int k = 0; k < 96; ++k) values.push_back(std::lround(100 * std::pow(10, k / 96.0)));
    return values;
  }();
  return series == PreferredSeries::e12 ? e12 : series == PreferredSeries::e24 ? e24 : e96;
}

int digits_of(PreferredSeries series) {
  return series == PreferredSeries::e96 ? 3 : 2;
}

}  // namespace

const std::vector<PreferredSeriesName>& preferred_series_names() {
  static const std::vector<PreferredSeriesName> names{
      {PreferredSeries::e12, "E12"}, {PreferredSeries::e24, "E24"}, {PreferredSeries::e96, "E96"}};
  return names;
}

std::string_view name_of(PreferredSeries series) {
  return preferred_series_names().at(static_cast<std::size_t>(series)).name;
}

const std::vector<double>& list_decade(PreferredSeries series) {
  static const auto decades = [] {
    std::vector<std::vector<double>> all;
    for (const auto& [of, name] : preferred_series_names())
      all.push_back(list_values(list_mantissas(of), digits_of(of), 1, 9.999));
    return all;
  }();
  return decades.at(static_cast<std::size_t>(series));
}

std::vector<double> list_preferred_values(PreferredSeries series, double low, double high) {
  return list_values(list_mantissas(series), digits_of(series), low, high);
}

std::vector<double> list_rounded_values(int digits, double low, double high) {
  const long first = std::lround(std::pow(10, digits - 1));
  std::vector<long> decade;
  for (long mantissa = first; mantissa < 10 * first; ++mantissa) decade.push_back(mantissa);
  return list_values(decade, digits, low, high);
}

}  // namespace gyrator
