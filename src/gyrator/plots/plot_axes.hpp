#pragma once

#include "gyrator/plots/plot.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// What an axis shows: from `low` to `high` in data units, divided by 10^exponent for the ticks.
struct AxisView {
  double low = 0;
  double high = 1;
  bool logarithmic = false;
  int exponent = 0;                     ///< a multiple of 3; 0 on a logarithmic axis
  std::string label;                    ///< with unit and power of ten
  std::vector<std::string> names = {};  ///< at 1, 2, … instead of numbers

  /// True where the axis can show `value` at all, in or out of its range.
  bool can_show(double value) const;
  /// The value as gnuplot gets it.
  double scaled(double value) const;
  /// 0 at `low`, 1 at `high`; logarithmic where the axis is.
  double fraction(double value) const;
};

struct PanelView {
  AxisView x;
  AxisView y;
};

/// Ranges that hold all of the panel's data with a margin, or what its axes ask for. With equal
/// aspect, the shorter range is widened to fit the panel of `width` × `height` pixels.
PanelView view_of(const Panel& panel, int width, int height);

}  // namespace gyrator
