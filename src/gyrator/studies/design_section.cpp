#include "gyrator/studies/design_section.hpp"

#include "gyrator/core/text.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/result_fields.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace gyrator {
namespace {

using nlohmann::json;
using Rows = std::vector<std::vector<HtmlCell>>;

constexpr const char* place = "design result";
constexpr std::array colours{Colour::blue, Colour::vermillion, Colour::green, Colour::orange,
                             Colour::purple};

const json& designs_of(const json& result) {
  return required_array(result, "designs", place);
}

// "2.4 ohm, 180 uF"
std::string values_in_words(const json& design) {
  std::vector<std::string> texts;
  for (const json& item : required_array(design, "bill_of_materials", place)) {
    const bool is_part = optional_text(item, "part") != "setting";
    texts.push_back((is_part ? "" : optional_text(item, "name") + " ") +
                    optional_text(item, "written"));
  }
  const json& values = required(design, "values", place);
  if (optional_flag(values, "digital.pre_emphasis", false)) texts.emplace_back("pre-emphasis");
  return join(texts);
}

// The limit that the spec set to a figure; NaN without one.
double find_limit(const json& result, const std::string& name) {
  for (const json& design : designs_of(result)) {
    for (const json& constraint : required_array(design, "constraints", place))
      if (optional_text(constraint, "name") == name) return optional_number(constraint, "limit");
  }
  return NAN;
}

// ---- Figure -----------------------------------------------------------------------------------

Curve front_curve(const json& front, Colour colour) {
  Curve curve{optional_text(front, "topology"), {}, {}, CurveStyle::line, colour};
  for (const json& point : required_array(front, "points", place)) {
    curve.x.push_back(required_number(point, "apparent_inertia", place));
    curve.y.push_back(required_number(point, "max_stiffness", place));
  }
  return curve;
}

Panel front_panel(const json& result) {
  Panel panel{"What stiffness costs in inertia, with parts that can be had",
              {"apparent inertia of the circuit", unit_of(result, "inertia")},
              {"largest passive stiffness", unit_of(result, "stiffness"), true}};
  std::size_t i = 0;
  for (const json& front : required_array(result, "fronts", place)) {
    const Curve line = front_curve(front, colours[i++ % colours.size()]);
    if (line.x.empty()) continue;
    Curve points = line;
    points.title.clear();
    points.style = CurveStyle::points;
    panel.curves.push_back(line);
    panel.curves.push_back(points);
  }
  int number = 1;
  for (const json& design : designs_of(result)) {
    const double inertia = required_number(design, "apparent_inertia", place);
    panel.markers.push_back({inertia, optional_number(design, "max_stiffness"),
                             fmt::format("{}: {}", number, values_in_words(design))});
    panel.markers.push_back({inertia, required_number(design, "rated_stiffness", place),
                             number == 1 ? "rated" : "", Colour::grey, MarkerShape::ring});
    ++number;
  }
  const double bound = find_limit(result, "apparent_inertia");
  if (std::isfinite(bound)) panel.lines.push_back({bound, true});
  const double wanted = find_limit(result, "max_stiffness");
  if (std::isfinite(wanted)) panel.lines.push_back({wanted, false});
  const bool logarithmic = std::all_of(panel.curves.begin(), panel.curves.end(),
                                       [](const Curve& curve) { return curve.x.front() > 0; });
  panel.x_axis.logarithmic = logarithmic && !panel.curves.empty();
  return panel;
}

Panel boundary_panel(const json& result) {
  Panel panel{"Passive walls of each design",
              {"virtual damping B", unit_of(result, "damping")},
              {"largest passive stiffness K", unit_of(result, "stiffness")}};
  const auto damping = required_numbers(result, "virtual_damping", place);
  std::size_t i = 0;
  for (const json& design : designs_of(result)) {
    const json& boundary = required(design, "boundary", place);
    const Colour colour = colours[i++ % colours.size()];
    panel.curves.push_back({fmt::format("{}: {}", i, optional_text(design, "topology")),
                            required_numbers(boundary, "damping", place),
                            required_numbers(boundary, "max_stiffness", place), CurveStyle::line,
                            colour});
    for (const double b : damping) {
      panel.markers.push_back({b, required_number(design, "rated_stiffness", place),
                               i == 1 && b == damping.front() ? "rated" : "", colour,
                               MarkerShape::ring});
    }
  }
  return panel;
}

// Where no device at all keeps the constraints, there is nothing to draw but the question.
Panel binding_panel(const json& result) {
  Panel panel{"What would have to give", {"", "", false, 0.5, 2.5}, {"share of the limit", ""}};
  panel.x_axis.names = {"asked for", "needed"};
  double share = NAN;
  if (has(result, "binding_constraint")) {
    const json& binding = result["binding_constraint"];
    share = optional_number(binding, "needed") / optional_number(binding, "limit");
    panel.title += ": " + optional_text(binding, "name");
  }
  panel.y_axis.min = 0;
  panel.y_axis.max = std::isfinite(share) ? 1.2 * std::max(1.0, share) : 1.2;
  panel.curves = {{"", {1, 2}, {1, share}, CurveStyle::impulses, Colour::vermillion}};
  return panel;
}

// ---- Report -----------------------------------------------------------------------------------

std::string per_cent(double share) {
  return pretty_number(100 * share, 4) + " %";
}

std::string unit_text(const json& object) {
  const std::string unit = optional_text(object, "unit");
  return unit == "1" ? "" : unit;
}

std::string designs_table(const json& result) {
  const std::string stiffness = unit_of(result, "stiffness");
  Rows rows;
  for (const json& design : designs_of(result)) {
    const std::string reason = optional_text(design, "loses_because");
    rows.push_back(
        {{std::to_string(rows.size() + 1), "number"},
         {optional_text(design, "topology")},
         {values_in_words(design)},
         {pretty_quantity(optional_number(design, "max_stiffness"), stiffness), "number"},
         {pretty_quantity(optional_number(design, "rated_stiffness"), stiffness), "number"},
         {pretty_quantity(optional_number(design, "apparent_inertia"), unit_of(result, "inertia")),
          "number"},
         {per_cent(optional_number(design, "yield")), "number"},
         {reason.empty() ? "the best" : reason}});
  }
  return html_table({"", "Topology", "Values", "Largest stiffness", "Rated", "Apparent inertia",
                     "Yield", "Why in this place"},
                    rows);
}

std::string bill_table(const json& design) {
  Rows rows;
  for (const json& item : required_array(design, "bill_of_materials", place)) {
    const double tolerance = optional_number(item, "tolerance");
    std::vector<std::string> remarks;
    if (item.contains("bipolar"))
      remarks.emplace_back(optional_flag(item, "bipolar", true) ? "bipolar" : "polarised");
    if (has(item, "arrangement")) remarks.push_back(optional_text(item, "arrangement"));
    if (has(item, "peak_power"))
      remarks.push_back(pretty_quantity(optional_number(item, "peak_power"), "W", 3) + " peak");
    if (has(item, "peak_voltage"))
      remarks.push_back(pretty_quantity(optional_number(item, "peak_voltage"), "V", 3) + " peak");
    rows.push_back({{pretty_number(optional_number(item, "count")), "number"},
                    {optional_text(item, "part")},
                    {optional_text(item, "written"), "number"},
                    {std::isnan(tolerance) ? "" : "± " + per_cent(tolerance), "number"},
                    {optional_text(item, "series")},
                    {join(remarks)},
                    {optional_text(item, "name")}});
  }
  return "<h3>Bill of materials</h3>\n" +
         html_table({"Count", "Part", "Value", "Tolerance", "Series", "Must stand", "Is"}, rows);
}

std::string constraints_table(const json& design) {
  Rows rows;
  for (const json& constraint : required_array(design, "constraints", place)) {
    const double value = optional_number(constraint, "value");
    const double limit = optional_number(constraint, "limit");
    const bool is_minimum = optional_text(constraint, "side") == "min";
    const double left = is_minimum ? value / limit - 1 : 1 - value / limit;
    const std::string unit = unit_text(constraint);
    rows.push_back({{optional_text(constraint, "name")},
                    {pretty_quantity(value, unit), "number"},
                    {(is_minimum ? "≥ " : "≤ ") + pretty_quantity(limit, unit), "number"},
                    {per_cent(left), "number"}});
  }
  if (rows.empty()) return {};
  return "<h3>Constraints</h3>\n" + html_table({"Figure", "Design", "Limit", "Left"}, rows);
}

std::string describe_binding(const json& result) {
  if (!has(result, "binding_constraint"))
    return "No stiffness is passive at this virtual damping with any of the topologies.";
  const json& binding = result["binding_constraint"];
  const std::string unit = unit_text(binding);
  return fmt::format("{} of {} would have to give to {} ({}){}.", optional_text(binding, "name"),
                     pretty_quantity(optional_number(binding, "limit"), unit),
                     pretty_quantity(optional_number(binding, "needed"), unit),
                     optional_text(binding, "topology"),
                     optional_flag(binding, "enough_alone", true) ? "" : ", and others with it");
}

}  // namespace

Figure design_figure(const json& result) {
  Figure figure{figure_title(result, "Designs"), {}};
  Panel front = front_panel(result);
  if (!front.curves.empty()) figure.panels.push_back(std::move(front));
  if (designs_of(result).empty()) {
    figure.panels.push_back(binding_panel(result));
  } else {
    figure.panels.push_back(boundary_panel(result));
  }
  figure.panel_width = 760;
  figure.panel_height = 380;
  return figure;
}

ReportSection design_section(const json& result) {
  const json& designs = designs_of(result);
  const std::string how_to_read =
      "Every point of a front is the lightest circuit of that topology for its stiffness; thin "
      "lines are what the spec asks for. Rings are the walls that the designs promise.";
  if (designs.empty()) return {"Design", html_paragraph(describe_binding(result)), how_to_read};
  return {"Design",
          designs_table(result) + bill_table(designs.front()) + constraints_table(designs.front()),
          how_to_read};
}

std::string design_sentence(const json& result) {
  const json& designs = designs_of(result);
  if (designs.empty()) return "No design: " + describe_binding(result);
  const json& best = designs.front();
  const std::string unit = unit_of(result, "stiffness");
  return fmt::format(
      "Best design: {} ({}), passive up to {}; rated at {}, which {} of the devices keep.",
      optional_text(best, "topology"), values_in_words(best),
      pretty_quantity(optional_number(best, "max_stiffness"), unit),
      pretty_quantity(optional_number(best, "rated_stiffness"), unit),
      per_cent(optional_number(best, "yield")));
}

}  // namespace gyrator
