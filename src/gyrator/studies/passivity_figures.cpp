// The figures about passivity: passivity_figure, zwidth_figure and finding_figure.

#include "gyrator/core/error.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_figures.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace gyrator {
namespace {

using nlohmann::json;
using Numbers = std::vector<double>;

double largest_magnitude(const Numbers& values) {
  double largest = 0;
  for (const double value : values)
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  return largest;
}

// ---- Passivity --------------------------------------------------------------------------------

/// The exact curve, the last one, may rise or fall without bound: the others set the scale, and
/// it leaves the picture.
void choose_damping_range(Panel& panel) {
  double low = 0;
  double high = 0;
  const auto include = [&](const Numbers& values, double limit) {
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, std::max(value, -limit));
      high = std::max(high, std::min(value, limit));
    }
  };
  double scale = 0;
  for (const auto& curve : panel.curves)
    if (&curve != &panel.curves.back()) scale = std::max(scale, largest_magnitude(curve.y));
  for (const auto& curve : panel.curves)
    include(curve.y, &curve == &panel.curves.back() && scale > 0 ? 4 * scale : INFINITY);
  if (high <= low) return;
  panel.y_axis.min = low - 0.06 * (high - low);
  panel.y_axis.max = high + 0.06 * (high - low);
}

/// Shades the frequencies at which the exact damping is negative.
void mark_failures(Panel& panel, const Numbers& frequency, const Numbers& exact) {
  if (!panel.y_axis.min || !panel.y_axis.max) return;
  Curve band{"fails here (exact)", frequency, {}, CurveStyle::band, Colour::vermillion};
  bool fails = false;
  for (const double value : exact) {
    fails |= value < 0;
    band.y.push_back(value < 0 ? *panel.y_axis.max : NAN);
    band.y_low.push_back(*panel.y_axis.min);
  }
  if (fails) panel.curves.insert(panel.curves.begin(), band);
}

Panel damping_panel(const json& result, bool logarithmic) {
  const std::string place = "passivity result: /damping_over_frequency";
  const auto& data = required(result, "damping_over_frequency", "passivity result");
  const auto frequency = required_numbers(data, "frequency_hz", place);
  const auto physical = required_numbers(data, "physical", place);
  const auto virtual_part = required_numbers(data, "virtual", place);
  const auto total = required_numbers(data, "total", place);
  const auto exact = required_numbers(data, "exact", place);
  Panel panel{logarithmic ? "Damping over frequency" : "The same, frequency linear up to Nyquist",
              {"frequency", "Hz", logarithmic},
              {"damping", unit_of(result, "damping")}};
  panel.curves = {{"of the device, Re Z", frequency, physical, CurveStyle::line, Colour::sky},
                  {"virtual, bᵥ", frequency, virtual_part, CurveStyle::line, Colour::orange},
                  {"sum (textbook)", frequency, total, CurveStyle::dashed, Colour::vermillion},
                  {"effective (exact)", frequency, exact, CurveStyle::line, Colour::blue}};
  panel.lines = {{0, false}};
  // Far below the Nyquist frequency nothing happens any more.
  if (logarithmic && !frequency.empty())
    panel.x_axis.min = std::max(frequency.front(), 1e-4 * frequency.back());
  choose_damping_range(panel);
  mark_failures(panel, frequency, exact);
  return panel;
}

struct Disk {
  double x = 0;
  double y = 0;
  double radius = 0;
  double critical_x = 0;
  double critical_y = 0;

  /// Of the critical point from the rim, positive outside.
  double distance() const { return std::hypot(critical_x - x, critical_y - y) - radius; }
};

Panel disk_panel(const json& result, const Disk& disk, const std::string& title) {
  Panel panel{title,
              {"real part of y/u", unit_of(result, "response")},
              {"imaginary part", unit_of(result, "response")}};
  panel.circles = {{disk.x, disk.y, disk.radius, true, "responses with passive operators"}};
  panel.markers = {
      {disk.critical_x, disk.critical_y, "−1/H", Colour::vermillion, MarkerShape::cross}};
  panel.lines = {{0, false}, {0, true}};
  panel.equal_aspect = true;
  return panel;
}

/// The rim near −1/H, seen along its tangent: at low frequency the disk is so large that only the
/// height above the rim, on a scale of its own, tells the inside from the outside.
Panel rim_panel(const json& result, const Disk& disk) {
  const double height = disk.distance();
  const double scale = std::max(std::abs(height), 1e-14 * disk.radius);
  // As far to both sides as the rim takes to curve away by three times that height.
  const double reach = std::min(std::sqrt(6 * disk.radius * scale), 0.9 * disk.radius);
  Curve rim{"inside the disk", {}, {}, CurveStyle::band, Colour::blue};
  for (int i = -60; i <= 60; ++i) {
    const double along = reach * i / 60;
    rim.x.push_back(along);
    rim.y.push_back(-along * along /
                    (disk.radius + std::sqrt(disk.radius * disk.radius - along * along)));
    rim.y_low.push_back(-4 * scale);
  }
  Panel panel{fmt::format("Close-up: −1/H is {} {} the rim",
                          pretty_quantity(std::abs(height), unit_of(result, "response"), 3),
                          height <= 0 ? "inside" : "outside"),
              {"along the rim", unit_of(result, "response")},
              {"height above the rim", unit_of(result, "response")}};
  panel.y_axis.min = -4 * scale;
  panel.y_axis.max = 2.5 * scale;
  Curve edge{"", rim.x, rim.y, CurveStyle::line, Colour::blue};
  panel.curves = {rim, edge};
  panel.markers = {{0, height, "−1/H", Colour::vermillion, MarkerShape::cross}};
  return panel;
}

/// The whole disk and, where −1/H is too near the rim to see on which side it is, a close-up.
std::vector<Panel> disk_panels(const json& result) {
  const std::string place = "passivity result: /disk";
  const auto& object = required(result, "disk", "passivity result");
  const auto number = [&](const char* key) { return required_number(object, key, place); };
  const Disk disk{number("center_real"), number("center_imag"), number("radius"),
                  number("critical_real"), number("critical_imag")};
  const double distance = disk.distance();
  if (!std::isfinite(distance)) return {};  // an active device has no disk
  std::vector<Panel> panels = {disk_panel(
      result, disk,
      fmt::format("Loop responses at {}: −1/H is {}", pretty_frequency(number("frequency_hz"), 3),
                  distance <= 0 ? "inside, fails" : "outside, holds"))};
  if (std::abs(distance) < 0.1 * disk.radius) panels.push_back(rim_panel(result, disk));
  return panels;
}

/// How much of a growing oscillation a linear axis can show: until it is 30 times what it was in
/// the first tenth.
std::size_t readable_length(const Numbers& position) {
  const std::size_t tenth = std::max<std::size_t>(position.size() / 10, 2);
  double early = 0;
  for (std::size_t i = 0; i < std::min(tenth, position.size()); ++i)
    if (std::isfinite(position[i])) early = std::max(early, std::abs(position[i]));
  for (std::size_t i = tenth; early > 0 && i < position.size(); ++i)
    if (!(std::abs(position[i]) <= 30 * early)) return i;
  return position.size();
}

bool has_counterexample_run(const json& passivity) {
  return has(passivity, "counterexample") && has(passivity["counterexample"], "simulation");
}

/// One signal of the counterexample's run, as far as a linear axis can show it.
Panel counterexample_signal(const json& result, const std::string& key,
                            const std::string& quantity) {
  const std::string place = "passivity result: /counterexample/simulation";
  const auto& run = required(result["counterexample"], "simulation", place);
  auto time = required_numbers(run, "time_s", place);
  auto values = required_numbers(run, key, place);
  const auto length = std::min(
      {readable_length(required_numbers(run, "position", place)), time.size(), values.size()});
  time.resize(length);
  values.resize(length);
  Panel panel{"", {"time", "s"}, {key, unit_of(result, quantity)}};
  panel.curves = {{"", time, values, CurveStyle::line, Colour::vermillion}};
  panel.lines = {{0, false}};
  return panel;
}

Panel counterexample_panel(const json& result) {
  Panel panel = counterexample_signal(result, "position", "position");
  const auto& run = result["counterexample"]["simulation"];
  auto words = operator_in_words(result);
  words.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(words.front())));
  const bool diverges = optional_text(run, "classification").starts_with("diverge");
  panel.title = words + (diverges ? ": diverges" : "");
  return panel;
}

Panel counterexample_command_panel(const json& result) {
  Panel panel = counterexample_signal(result, "command", "effort");
  panel.title = "The controller's command in that run";
  panel.curves.front().style = CurveStyle::steps;
  panel.curves.front().colour = Colour::orange;
  return panel;
}

// ---- Z-width ----------------------------------------------------------------------------------

Colour criterion_colour(const std::string& name) {
  static constexpr std::array<std::pair<std::string_view, Colour>, 6> colours = {{
      {"spring_damper", Colour::grey},
      {"frequency_dependent", Colour::vermillion},
      {"exact_disk", Colour::blue},
      {"quantized_coulomb", Colour::purple},
      {"coupled", Colour::green},
      {"time", Colour::black},
  }};
  for (const auto& [known, colour] : colours)
    if (name == known) return colour;
  return Colour::black;
}

struct Boundary {
  std::string criterion;
  Numbers damping;
  Numbers stiffness;
  std::vector<bool> feasible;  ///< false where not even zero stiffness is allowed

  /// The stiffness down to the axis, and no number beyond, where none is allowed.
  Numbers drawn() const {
    const auto allowed = [&](std::size_t i) { return i >= feasible.size() || feasible[i]; };
    Numbers values = stiffness;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool next_to_allowed =
          (i > 0 && allowed(i - 1)) || (i + 1 < values.size() && allowed(i + 1));
      if (!allowed(i)) values[i] = next_to_allowed ? 0 : NAN;
    }
    return values;
  }
};

std::vector<Boundary> boundaries_of(const json& zwidth) {
  const auto& list = required_array(zwidth, "boundaries", "zwidth result");
  std::vector<Boundary> boundaries;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto place = fmt::format("zwidth result: /boundaries/{}", i);
    boundaries.push_back({optional_text(list[i], "criterion"),
                          required_numbers(list[i], "damping", place),
                          required_numbers(list[i], "max_stiffness", place),
                          {}});
    if (has(list[i], "feasible"))
      for (const auto& flag : list[i]["feasible"])
        boundaries.back().feasible.push_back(flag != json(false));
  }
  return boundaries;
}

Panel boundary_panel(const json& result, const std::vector<Boundary>& boundaries) {
  Panel panel{"Largest stiffness over virtual damping",
              {"virtual damping B", unit_of(result, "damping")},
              {"stiffness K", unit_of(result, "stiffness")}};
  for (const auto& boundary : boundaries)
    panel.curves.push_back(
        {criterion_title(boundary.criterion), boundary.damping, boundary.drawn(),
         boundary.criterion == "spring_damper" ? CurveStyle::dashed : CurveStyle::line,
         criterion_colour(boundary.criterion)});
  return panel;
}

void add_point(Panel& panel, double damping, double stiffness) {
  if (std::isfinite(damping) && std::isfinite(stiffness))
    panel.markers.push_back(
        {damping, stiffness, "this model, K = " + pretty_number(stiffness, 3), Colour::black});
}

/// The finding's left panel: the stiffness between the textbook's limit and the true one shaded.
Panel finding_panel(const json& passivity, const json& zwidth, const Finding& finding) {
  std::vector<Boundary> shown;
  for (const auto& boundary : boundaries_of(zwidth))
    if (boundary.criterion == "spring_damper" || boundary.criterion == "frequency_dependent" ||
        boundary.criterion == "exact_disk")
      shown.push_back(boundary);
  Panel panel = boundary_panel(zwidth, shown);
  const auto find = [&](std::string_view name) {
    return std::find_if(shown.begin(), shown.end(),
                        [&](const Boundary& boundary) { return boundary.criterion == name; });
  };
  const auto textbook = find("frequency_dependent");
  const auto exact = find("exact_disk");
  if (textbook != shown.end() && exact != shown.end() && textbook->damping == exact->damping &&
      textbook->stiffness.size() == exact->stiffness.size()) {
    Curve band{"passive by the textbook, yet not",
               textbook->damping,
               {},
               CurveStyle::band,
               Colour::vermillion};
    for (std::size_t i = 0; i < textbook->stiffness.size(); ++i) {
      const double low = exact->stiffness[i];
      band.y_low.push_back(low);
      band.y.push_back(textbook->stiffness[i] >= low ? textbook->stiffness[i] : low);
    }
    panel.curves.insert(panel.curves.begin(), band);
  }

  const double damping = optional_number(passivity, "virtual_damping");
  add_point(panel, damping, optional_number(passivity, "stiffness"));
  const auto add_limit = [&](const std::string& name, double limit, Colour colour) {
    if (std::isfinite(damping) && std::isfinite(limit))
      panel.markers.push_back(
          {damping, limit, name + " " + pretty_number(limit, 3), colour, MarkerShape::ring});
  };
  add_limit("textbook limit", finding.textbook_limit, Colour::vermillion);
  add_limit("true limit", finding.true_limit, Colour::blue);
  return panel;
}

}  // namespace

Figure passivity_figure(const json& result) {
  Figure figure{figure_title(result, "Passivity"), {}, 2};
  if (has(result, "damping_over_frequency"))
    figure.panels = {damping_panel(result, true), damping_panel(result, false)};
  if (has(result, "disk"))
    for (auto& panel : disk_panels(result)) figure.panels.push_back(std::move(panel));
  if (has_counterexample_run(result)) {
    figure.panels.push_back(counterexample_panel(result));
    if (figure.panels.size() % 2 == 1 && has(result["counterexample"]["simulation"], "command"))
      figure.panels.push_back(counterexample_command_panel(result));
  }
  return figure;
}

Figure zwidth_figure(const json& result) {
  Panel panel = boundary_panel(result, boundaries_of(result));
  for (const auto& boundary : result["boundaries"]) {
    if (!has(boundary, "map")) continue;
    auto cells = time_map_cells(boundary);
    panel.y_axis.min = 0;
    panel.y_axis.max = *std::max_element(cells.back().y.begin(), cells.back().y.end());
    for (const Curve& curve : cells)
      panel.y_axis.max =
          std::max(*panel.y_axis.max, *std::max_element(curve.y.begin(), curve.y.end()));
    panel.curves.insert(panel.curves.begin(), cells.begin(), cells.end());
  }
  if (has(result, "point"))
    add_point(panel, optional_number(result["point"], "damping"),
              optional_number(result["point"], "stiffness"));
  panel.title.clear();
  Figure figure{figure_title(result, "Z-width"), {panel}};
  figure.panel_width = 760;
  figure.panel_height = 440;
  return figure;
}

Figure finding_figure(const json& passivity, const json& zwidth) {
  const auto finding = finding_of(passivity);
  Figure figure{"", {}, 2};
  if (!zwidth.is_null()) figure.panels.push_back(finding_panel(passivity, zwidth, finding));
  if (has_counterexample_run(passivity)) figure.panels.push_back(counterexample_panel(passivity));
  if (figure.panels.empty())
    throw Error(ErrorCode::bad_input, "finding figure",
                "neither a zwidth result nor a counterexample's run to show");
  figure.title =
      figure_title(passivity, finding.unsafe() ? "The textbook's limit is unsafe here"
                                               : "The textbook's limit and the true one");
  figure.panel_height = 400;
  return figure;
}

}  // namespace gyrator
