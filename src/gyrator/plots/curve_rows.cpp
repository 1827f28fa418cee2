#include "gyrator/plots/curve_rows.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include <fmt/format.h>

namespace gyrator {
namespace {

std::vector<double> circle_angles(const Circle& circle, const PanelView& view) {
  constexpr int coarse = 240;
  constexpr double step = 2 * std::numbers::pi / coarse;
  const double chord = step * circle.radius;
  const double x = 0.5 * (view.x.low + view.x.high);
  const double y = 0.5 * (view.y.low + view.y.high);
  const double reach = std::hypot(view.x.high - x, view.y.high - y);
  const int parts = std::clamp(static_cast<int>(std::min(1e6, 40 * chord / reach)), 1, 1000);
  std::vector<double> angles;
  for (int i = 0; i < coarse; ++i) {
    const double at_x = circle.centre_x + circle.radius * std::cos((i + 0.5) * step);
    const double at_y = circle.centre_y + circle.radius * std::sin((i + 0.5) * step);
    const bool near = std::hypot(at_x - x, at_y - y) < reach + chord;
    for (int part = 0; part < (near ? parts : 1); ++part)
      angles.push_back((i + static_cast<double>(part) / parts) * step);
  }
  angles.push_back(2 * std::numbers::pi);
  return angles;
}

}  // namespace

std::vector<Row> rows_of(const Curve& curve, const PanelView& view) {
  std::vector<Row> rows;
  rows.reserve(curve.x.size());
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    const double low = curve.style == CurveStyle::band ? curve.y_low[i] : curve.y[i];
    const bool shown =
        view.x.can_show(curve.x[i]) && view.y.can_show(curve.y[i]) && view.y.can_show(low);
    rows.push_back({shown, curve.x[i], curve.y[i], low});
  }
  return rows;
}

std::vector<Row> rows_of(const Circle& circle, const PanelView& view) {
  std::vector<Row> rows;
  for (const double angle : circle_angles(circle, view)) {
    const double x = circle.centre_x + circle.radius * std::cos(angle);
    const double y = circle.centre_y + circle.radius * std::sin(angle);
    rows.push_back({view.x.can_show(x) && view.y.can_show(y), x, y, y});
  }
  return rows;
}

std::vector<std::size_t> boxes_shown(const Curve& curve, const PanelView& view) {
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (view.x.can_show(curve.x[i]) && view.x.can_show(curve.x_high[i]) &&
        view.y.can_show(curve.y_low[i]) && view.y.can_show(curve.y[i]))
      shown.push_back(i);
  }
  return shown;
}

std::vector<Row> thinned(const std::vector<Row>& rows, const PanelView& view, int columns,
                         std::size_t allowed) {
  if (rows.size() <= allowed) return rows;
  const auto column_of = [&](const Row& row) {
    return std::floor(std::clamp(view.x.fraction(row.x), -0.1, 1.1) * columns);
  };
  const auto by_height = [](const Row& a, const Row& b) { return a.y < b.y; };
  std::vector<Row> kept;
  for (auto from = rows.begin(); from != rows.end();) {
    if (!from->shown) {
      kept.push_back(*from++);
      continue;
    }
    const auto to = std::find_if(from, rows.end(), [&](const Row& row) {
      return !row.shown || column_of(row) != column_of(*from);
    });
    const auto [lowest, highest] = std::minmax_element(from, to, by_height);
    auto corners = {from, std::min(lowest, highest), std::max(lowest, highest), std::prev(to)};
    auto last = rows.end();
    for (const auto at : corners) {
      if (at != last) kept.push_back(*at);
      last = at;
    }
    from = to;
  }
  return kept;
}

void check_lengths(const Panel& panel, const Curve& curve) {
  const bool boxes = curve.style == CurveStyle::boxes;
  const bool low_missing =
      (boxes || curve.style == CurveStyle::band) && curve.y_low.size() != curve.x.size();
  const bool high_missing = boxes && curve.x_high.size() != curve.x.size();
  if (curve.x.size() == curve.y.size() && !low_missing && !high_missing) return;
  throw Error(
      ErrorCode::bad_input, "figure",
      fmt::format("panel \"{}\", curve \"{}\": {} values of x, {} of y, {} of y_low: they "
                  "must be as many",
                  panel.title, curve.title, curve.x.size(), curve.y.size(), curve.y_low.size()));
}

}  // namespace gyrator
