#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace gyrator {

/// The series of preferred values that parts are sold in: so many to a decade (IEC 60063).
enum class PreferredSeries { e12, e24, e96 };

struct PreferredSeriesName {
  PreferredSeries series;
  std::string_view name;  ///< "E24"
};
const std::vector<PreferredSeriesName>& preferred_series_names();
std::string_view name_of(PreferredSeries series);

/// The values of one decade, 1 … 10 without the 10, rising.
const std::vector<double>& list_decade(PreferredSeries series);

/// All values of the series from `low` to `high`, both included, rising. Each is the double nearest
/// to its decimal text, so that 470e-6 is what "470 uF" reads as. Requires 0 < low <= high.
std::vector<double> list_preferred_values(PreferredSeries series, double low, double high);

/// All numbers of `digits` significant digits in the range, for what is set and not bought.
std::vector<double> list_rounded_values(int digits, double low, double high);

}  // namespace gyrator
