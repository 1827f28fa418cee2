#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_figures.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr const char* place = "tolerance result";
constexpr std::size_t most_bars = 12;

Curve vertical_line(std::string title, double x, double top, Colour colour, CurveStyle style) {
  return {std::move(title), {x, x}, {0, top}, style, colour};
}

// So that nothing lies on the frame.
void leave_room(Axis& axis, std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double room = 0.04 * (*high - *low);
  if (!(room > 0)) return;
  axis.min = std::max(0.0, *low - room);
  axis.max = *high + room;
}

// Share of the samples per bin, with the limits that matter marked.
Panel distribution_panel(const json& result) {
  const json& samples = required(result, "samples", place);
  const json& histogram = required(samples, "histogram", place);
  const auto edges = required_numbers(histogram, "edges", place);
  const auto counts = required_numbers(histogram, "count", place);
  const double total = required_number(samples, "count", place);
  Panel panel{"Distribution of the largest passive stiffness",
              {"K", unit_of(result, "stiffness")},
              {"share of the samples per bin", "%"}};
  Curve bins{"samples", {}, {}, CurveStyle::area, Colour::sky};
  double top = 0;
  for (std::size_t i = 0; i + 1 < edges.size() && i < counts.size(); ++i) {
    const double share = 100 * counts[i] / total;
    bins.x.insert(bins.x.end(), {edges[i], edges[i + 1]});
    bins.y.insert(bins.y.end(), {share, share});
    top = std::max(top, share);
  }
  if (bins.x.empty()) {  // all the same, or unbounded
    top = 1;
  } else {
    panel.curves.push_back(bins);
  }
  std::vector<double> marked = edges;
  const auto add = [&](const char* title, double x, Colour colour, CurveStyle style) {
    if (std::isfinite(x)) panel.curves.push_back(vertical_line(title, x, top, colour, style));
    marked.push_back(x);
  };
  add("nominal", optional_number(required(result, "nominal", place), "max_stiffness"), Colour::blue,
      CurveStyle::line);
  add("worst case found", optional_number(required(result, "worst", place), "max_stiffness"),
      Colour::vermillion, CurveStyle::line);
  const double wall = required_number(result, "stiffness", place);
  // A wall far off would leave nothing to see of the distribution.
  const double spread = edges.empty() ? 0 : edges.back() - edges.front();
  const bool is_far =
      !edges.empty() && (wall > edges.back() + spread || wall < edges.front() - spread);
  if (is_far) {
    panel.title += fmt::format(" (the model's K = {:.4g} lies far {})", wall,
                               wall > edges.back() ? "above" : "below");
  } else {
    add("the model's K", wall, Colour::black, CurveStyle::dashed);
  }
  leave_room(panel.x_axis, marked);
  panel.y_axis.min = 0;
  panel.y_axis.max = 1.05 * top;
  return panel;
}

// What one part alone does, the strongest on top.
Panel tornado_panel(const json& result) {
  const json& parts = required_array(result, "parts", place);
  const double nominal = optional_number(required(result, "nominal", place), "max_stiffness");
  const std::size_t count = std::min(most_bars, parts.size());
  Panel panel{parts.size() > count
                  ? fmt::format("The {} strongest parts, each alone, the strongest on top", count)
                  : "Each part alone at the ends of its range, the strongest on top",
              {"K", unit_of(result, "stiffness")},
              {"", ""}};
  panel.y_axis.names.resize(count);
  Curve low{"at the low end", {}, {}, CurveStyle::band, Colour::blue, {}};
  Curve high{"at the high end", {}, {}, CurveStyle::band, Colour::vermillion, {}};
  // A band per part; a value that is no number keeps it from the next one.
  const auto add_bar = [&](Curve& bars, double limit, double rank) {
    for (const double x : {nominal, limit, std::nan("")}) {
      bars.x.push_back(x);
      bars.y.push_back(rank + 0.3);
      bars.y_low.push_back(rank - 0.3);
    }
  };
  std::vector<double> ends;
  for (std::size_t i = 0; i < count; ++i) {
    const auto rank = static_cast<double>(count - i);
    const double at_low = optional_number(parts[i], "max_stiffness_at_low");
    const double at_high = optional_number(parts[i], "max_stiffness_at_high");
    if (std::isfinite(at_low)) add_bar(low, at_low, rank);
    if (std::isfinite(at_high)) add_bar(high, at_high, rank);
    ends.insert(ends.end(), {nominal, at_low, at_high});
    panel.y_axis.names[count - 1 - i] = optional_text(parts[i], "name");
  }
  panel.curves = {low, high};
  if (std::isfinite(nominal)) panel.lines.push_back({nominal, true});
  leave_room(panel.x_axis, ends);
  panel.y_axis.min = 0.4;
  panel.y_axis.max = static_cast<double>(count) + 0.6;
  return panel;
}

}  // namespace

Figure tolerance_figure(const json& result) {
  Figure figure{figure_title(result, "Tolerances of parts"),
                {distribution_panel(result), tornado_panel(result)}};
  figure.panel_width = 760;
  figure.panel_height = 400;
  return figure;
}

}  // namespace gyrator
