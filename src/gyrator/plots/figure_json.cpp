#include "gyrator/plots/figure_json.hpp"

#include "gyrator/plots/curve_rows.hpp"
#include "gyrator/plots/plot_axes.hpp"
#include "gyrator/plots/plot_labels.hpp"
#include "gyrator/plots/plot_page.hpp"
#include "gyrator/plots/pretty_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace gyrator {
namespace {

constexpr std::size_t most_points = 4000;  // of a curve
constexpr int thinning_columns = 1000;

const char* name_of(CurveStyle style) {
  switch (style) {
    case CurveStyle::line:
      return "line";
    case CurveStyle::dashed:
      return "dashed";
    case CurveStyle::dotted:
      return "dotted";
    case CurveStyle::steps:
      return "steps";
    case CurveStyle::points:
      return "points";
    case CurveStyle::impulses:
      return "impulses";
    case CurveStyle::area:
      return "area";
    case CurveStyle::band:
      return "band";
    case CurveStyle::boxes:
      break;
  }
  return "boxes";
}

const char* name_of(MarkerShape shape) {
  switch (shape) {
    case MarkerShape::dot:
      return "dot";
    case MarkerShape::cross:
      return "cross";
    case MarkerShape::ring:
      break;
  }
  return "ring";
}

/// A JSON string that can stand in any element of the page.
std::string text(std::string_view any) {
  std::string safe;
  for (const char c : nlohmann::json(plain_text(any)).dump()) {
    if (c == '<' || c == '>' || c == '&') {
      safe += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string number(double value, int digits = 10) {
  return std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : "null";
}

/// Digits with which values at the far end of the axis differ by a 10⁶th of its length.
int digits_for(const AxisView& axis) {
  if (axis.logarithmic) return 7;
  const double size = std::max(std::abs(axis.low), std::abs(axis.high));
  const double ratio = size / (axis.high - axis.low);
  return std::clamp(6 + static_cast<int>(std::ceil(std::log10(ratio))), 7, 17);
}

/// All lists of numbers of a figure: panels often share their time or frequency.
class Numbers {
 public:
  /// The list's place; a new one only where no list is the same.
  std::size_t add(const std::vector<std::string>& values) {
    const auto list = fmt::format("[{}]", fmt::join(values, ","));
    const auto [at, is_new] = places_.emplace(list, places_.size());
    if (is_new) lists_.push_back(list);
    return at->second;
  }
  std::string as_json() const { return fmt::format("[{}]", fmt::join(lists_, ",\n")); }

 private:
  std::map<std::string, std::size_t> places_;
  std::vector<std::string> lists_;
};

/// The columns of a curve as JSON members.
class Columns {
 public:
  explicit Columns(const PanelView& view)
      : x_digits_(digits_for(view.x)), y_digits_(digits_for(view.y)) {}

  void add_row(double x_value, double y_value) {
    x.push_back(number(x_value, x_digits_));
    y.push_back(number(y_value, y_digits_));
  }
  void add_low(double value) { y_low.push_back(number(value, y_digits_)); }
  void add_right(double value) { x_high.push_back(number(value, x_digits_)); }

  std::string members(Numbers& numbers) const {
    auto json = fmt::format(R"("x":{},"y":{})", numbers.add(x), numbers.add(y));
    if (!y_low.empty()) json += fmt::format(R"(,"y_low":{})", numbers.add(y_low));
    if (!x_high.empty()) json += fmt::format(R"(,"x_high":{})", numbers.add(x_high));
    return json;
  }

 private:
  std::vector<std::string> x, y, y_low, x_high;
  int x_digits_, y_digits_;
};

Columns columns_of(const Curve& curve, const PanelView& view) {
  Columns columns(view);
  if (curve.style == CurveStyle::boxes) {
    for (const auto i : boxes_shown(curve, view)) {
      columns.add_row(curve.x[i], curve.y[i]);
      columns.add_low(curve.y_low[i]);
      columns.add_right(curve.x_high[i]);
    }
    return columns;
  }
  auto rows = rows_of(curve, view);
  const bool band = curve.style == CurveStyle::band;
  if (!band) rows = thinned(rows, view, thinning_columns, most_points);
  double x = view.x.low;  // a missing x is as good as the one before: nothing is drawn there
  for (const auto& row : rows) {
    if (view.x.can_show(row.x)) x = row.x;
    columns.add_row(x, row.shown ? row.y : NAN);
    if (band) columns.add_low(row.shown ? row.y_low : NAN);
  }
  return columns;
}

std::string curve_json(const std::string& title, const char* style, Colour colour,
                       const Columns& columns, Numbers& numbers) {
  return fmt::format(R"({{"title":{},"style":"{}","colour":"{}",{}}})", text(title), style,
                     hex(colour), columns.members(numbers));
}

std::string circle_json(const Circle& circle, const PanelView& view, Numbers& numbers) {
  Columns columns(view);
  for (const auto& row : rows_of(circle, view))
    if (row.shown) columns.add_row(row.x, row.y);
  return curve_json(circle.title, circle.filled ? "disk" : "circle", circle.colour, columns,
                    numbers);
}

std::string axis_json(const Axis& axis, const AxisView& view) {
  std::vector<std::string> names;
  for (const auto& name : view.names) names.push_back(text(name));
  return fmt::format(
      R"({{"label":{},"name":{},"unit":{},"logarithmic":{},"low":{},"high":{},"exponent":{},"names":[{}]}})",
      text(view.label), text(axis.label), text(pretty_unit(axis.unit)), view.logarithmic,
      number(view.low, 17), number(view.high, 17), view.exponent, fmt::join(names, ","));
}

/// Each with the way from the point to where its label begins in the picture, in pixels.
std::vector<std::string> markers_json(const Panel& panel, const PanelView& view,
                                      const PanelPlace& place) {
  const auto spots = place_labels(panel, view, place);
  std::vector<std::string> markers;
  for (std::size_t i = 0; i < panel.markers.size(); ++i) {
    const auto& marker = panel.markers[i];
    if (!view.x.can_show(marker.x) || !view.y.can_show(marker.y)) continue;
    const double left = place.left + view.x.fraction(marker.x) * place.width();
    const double middle = place.bottom - view.y.fraction(marker.y) * place.height();
    markers.push_back(fmt::format(
        R"({{"x":{},"y":{},"label":{},"colour":"{}","shape":"{}","right":{:.0f},"down":{:.0f}}})",
        number(marker.x, 17), number(marker.y, 17), text(marker.label), hex(marker.colour),
        name_of(marker.shape), spots[i].left - left, spots[i].middle - middle));
  }
  return markers;
}

std::string panel_json(const Panel& panel, const PanelPlace& place, Numbers& numbers) {
  const auto view = view_of(panel, place.width(), place.height());
  std::vector<std::string> curves;
  for (const auto& circle : panel.circles) curves.push_back(circle_json(circle, view, numbers));
  for (const auto& curve : panel.curves) {
    check_lengths(panel, curve);
    curves.push_back(curve_json(curve.title, name_of(curve.style), curve.colour,
                                columns_of(curve, view), numbers));
  }
  std::vector<std::string> lines;
  for (const auto& line : panel.lines)
    if ((line.vertical ? view.x : view.y).can_show(line.value))
      lines.push_back(
          fmt::format(R"({{"value":{},"vertical":{}}})", number(line.value, 17), line.vertical));
  return fmt::format(
      R"({{"title":{},"equal_aspect":{},"x":{},"y":{},"curves":[{}],"markers":[{}],"lines":[{}]}})",
      text(panel.title), panel.equal_aspect, axis_json(panel.x_axis, view.x),
      axis_json(panel.y_axis, view.y), fmt::join(curves, ",\n"),
      fmt::join(markers_json(panel, view, place), ","), fmt::join(lines, ","));
}

}  // namespace

std::string figure_as_json(const Figure& figure) {
  const auto page = lay_out(figure, 1);
  Numbers numbers;
  std::vector<std::string> panels;
  for (std::size_t i = 0; i < figure.panels.size(); ++i)
    panels.push_back(panel_json(figure.panels[i], page.places[i], numbers));
  return fmt::format(
      R"({{"columns":{},"panel_width":{},"panel_height":{},"panels":[{}],"numbers":{}}})",
      std::clamp(figure.columns, 1, static_cast<int>(figure.panels.size())), figure.panel_width,
      figure.panel_height, fmt::join(panels, ",\n"), numbers.as_json());
}

}  // namespace gyrator
