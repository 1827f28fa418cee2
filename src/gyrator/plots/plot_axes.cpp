#include "gyrator/plots/plot_axes.hpp"

#include "gyrator/plots/pretty_text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrator {
namespace {

constexpr double largest = 1e200;  // beyond, margins and scales would overflow; counts as no number
constexpr double log_span_limit = 1e10;  // a rounding error near zero must not stretch the axis

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  bool empty() const { return low > high; }
  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

struct Extents {
  Extent x;
  Extent y;
  bool stems = false;  // something reaches down to y = 0
};

Extents extents_of(const Panel& panel, const AxisView& x, const AxisView& y) {
  Extents extents;
  const auto include = [&](double at, double value) {
    if (!x.can_show(at) || !y.can_show(value)) return;
    extents.x.include(at);
    extents.y.include(value);
  };
  for (const auto& curve : panel.curves) {
    for (std::size_t i = 0; i < curve.x.size(); ++i) include(curve.x[i], curve.y[i]);
    for (std::size_t i = 0; i < curve.y_low.size(); ++i) include(curve.x[i], curve.y_low[i]);
    for (std::size_t i = 0; i < curve.x_high.size(); ++i) include(curve.x_high[i], curve.y[i]);
    extents.stems |= curve.style == CurveStyle::area || curve.style == CurveStyle::impulses;
  }
  for (const auto& circle : panel.circles)
    for (const double sign : {-1.0, 1.0})
      include(circle.centre_x + sign * circle.radius, circle.centre_y + sign * circle.radius);
  for (const auto& marker : panel.markers) include(marker.x, marker.y);
  return extents;
}

void choose_linear(AxisView& view, Extent extent, double margin) {
  if (extent.empty()) extent = {0, 1};
  double span = extent.high - extent.low;
  const double size = std::max(std::abs(extent.low), std::abs(extent.high));
  if (span <= 1e-12 * size || span == 0) {
    margin = 1;
    span = size > 0 ? 0.2 * size : 1;
  }
  // A range that begins at zero keeps zero at its edge.
  view.low = extent.low == 0 && margin < 1 ? 0 : extent.low - margin * span;
  view.high = extent.high == 0 && margin < 1 ? 0 : extent.high + margin * span;
}

void choose_logarithmic(AxisView& view, Extent extent, double margin) {
  if (extent.empty()) extent = {0.1, 10};
  extent.low = std::max(extent.low, extent.high / log_span_limit);
  const double padding = std::pow(extent.high / extent.low, margin);
  view.low = extent.low / padding;
  view.high = extent.high * padding;
  // An axis needs two labelled decades to be read.
  const double first = std::ceil(std::log10(view.low) - 1e-9);
  const double last = std::floor(std::log10(view.high) + 1e-9);
  if (last > first) return;
  const double edge = std::pow(10.0, margin);
  view.low = std::pow(10.0, std::floor(std::log10(extent.low) + 1e-9));
  view.high = std::max(10 * view.low, std::pow(10.0, std::ceil(std::log10(extent.high) - 1e-9)));
  view.low /= edge;
  view.high *= edge;
}

void choose_range(AxisView& view, const Axis& axis, Extent extent, double margin) {
  if (axis.logarithmic) {
    choose_logarithmic(view, extent, margin);
  } else {
    choose_linear(view, extent, margin);
  }
  if (axis.min && view.can_show(*axis.min)) view.low = *axis.min;
  if (axis.max && view.can_show(*axis.max)) view.high = *axis.max;
  if (view.high <= view.low) {  // the axis asks for a range without the data
    const double span = view.logarithmic ? 9 * view.low : std::max(1.0, std::abs(view.low));
    view.high = view.low + span;
  }
}

void widen(AxisView& view, double span) {
  const double middle = 0.5 * (view.low + view.high);
  view.low = middle - 0.5 * span;
  view.high = middle + 0.5 * span;
}

void choose_label(AxisView& view, const Axis& axis) {
  const double size = std::max(std::abs(view.low), std::abs(view.high));
  if (view.names.empty() && !view.logarithmic && (size >= 1e5 || size < 0.05) && size > 0)
    view.exponent = 3 * static_cast<int>(std::floor(std::log10(size) / 3));
  if (axis.label.empty()) return;
  std::string unit = pretty_unit(axis.unit);
  if (view.exponent != 0) {
    const std::string power = "10" + superscript(view.exponent);
    unit = unit.empty() ? "×" + power : power + " " + unit;
  }
  view.label = unit.empty() ? axis.label : axis.label + " [" + unit + "]";
}

}  // namespace

bool AxisView::can_show(double value) const {
  return std::abs(value) < largest && (!logarithmic || value > 0);  // false for NaN
}

double AxisView::scaled(double value) const {
  return value * std::pow(10.0, -exponent);
}

double AxisView::fraction(double value) const {
  if (logarithmic) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

PanelView view_of(const Panel& panel, int width, int height) {
  PanelView view;
  view.x.logarithmic = panel.x_axis.logarithmic;
  view.y.logarithmic = panel.y_axis.logarithmic;
  Extents extents = extents_of(panel, view.x, view.y);
  if (extents.stems && !view.y.logarithmic) extents.y.include(0);

  const bool planar = panel.equal_aspect || !panel.circles.empty();
  choose_range(view.x, panel.x_axis, extents.x, planar ? 0.06 : 0.0);
  choose_range(view.y, panel.y_axis, extents.y, 0.06);
  if (panel.equal_aspect && !view.x.logarithmic && !view.y.logarithmic) {
    const double shape = static_cast<double>(width) / height;
    const double x_span = view.x.high - view.x.low;
    const double y_span = view.y.high - view.y.low;
    widen(view.x, std::max(x_span, y_span * shape));
    widen(view.y, std::max(y_span, x_span / shape));
  }
  view.x.names = panel.x_axis.names;
  view.y.names = panel.y_axis.names;
  choose_label(view.x, panel.x_axis);
  choose_label(view.y, panel.y_axis);
  return view;
}

}  // namespace gyrator
