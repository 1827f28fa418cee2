#include "gyrator/core/error.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace gyrator {
namespace {

using nlohmann::json;

struct Look {
  Colour colour;
  CurveStyle style;
};
// Curves often lie on each other: a dashed one over a line shows both.
constexpr std::array<Look, 3> looks{{{Colour::vermillion, CurveStyle::line},
                                     {Colour::blue, CurveStyle::dashed},
                                     {Colour::green, CurveStyle::line}}};

std::string title_of(const json& part) {
  auto name = optional_text(part, "rendering");
  std::replace(name.begin(), name.end(), '_', ' ');
  return name == "remote" ? "two devices" : name;
}

Panel make_panel(const json& parts, const std::string& title, const Axis& y_axis, const char* key) {
  Panel panel{title, {"frequency", "Hz", true}, y_axis};
  std::size_t i = 0;
  for (const auto& part : parts) {
    const Look& look = looks[i++ % looks.size()];
    panel.curves.push_back(
        {title_of(part), required_numbers(part, "frequency_hz", "twoport result: /renderings"),
         required_numbers(part, key, "twoport result: /renderings"), look.style, look.colour});
  }
  return panel;
}

// Over decades where everything is positive, else linear with the zero line.
void choose_scale(Panel& panel) {
  bool positive = true;
  for (const auto& curve : panel.curves)
    positive =
        positive && std::none_of(curve.y.begin(), curve.y.end(), [](double y) { return y <= 0; });
  panel.y_axis.logarithmic = positive;
  if (!positive) panel.lines = {{0, false}};
}

// Around zero, where it is decided: what is far above it leaves the picture.
void show_around_zero(Panel& panel) {
  panel.lines = {{0, false}};
  double low = 0, high = 0;
  for (const auto& curve : panel.curves) {
    for (const double y : curve.y) {
      if (!std::isfinite(y)) continue;
      low = std::min(low, y);
      high = std::max(high, y);
    }
  }
  if (low == 0) return;
  panel.y_axis.min = 1.1 * low;
  panel.y_axis.max = std::min(1.1 * high, -1.1 * low);
  panel.y_axis.max = std::max(*panel.y_axis.max, -0.1 * low);
}

// Where the environment has no impedance to compare with: a free port, or a clamped one.
Panel felt_panel(const json& parts, const std::string& damping) {
  Panel panel = make_panel(parts, "Impedance felt", {"|Zₜₑ|", damping}, "transmitted_real");
  for (std::size_t i = 0; i < panel.curves.size(); ++i) {
    const auto imag = required_numbers(parts[i], "transmitted_imag", "twoport result: /renderings");
    for (std::size_t j = 0; j < std::min(imag.size(), panel.curves[i].y.size()); ++j)
      panel.curves[i].y[j] = std::hypot(panel.curves[i].y[j], imag[j]);
  }
  return panel;
}

}  // namespace

Figure two_port_figure(const json& result) {
  const json& parts = required_array(result, "renderings", "twoport result");
  const std::string damping = unit_of(result, "damping");
  Panel first = make_panel(parts, "Condition 1: Re h₁₁ ≥ 0", {"Re h₁₁", damping}, "h11_real");
  choose_scale(first);
  const bool rotary = damping.find("rad") != std::string::npos;
  Panel second = make_panel(parts, "Condition 2: Re h₂₂ ≥ 0",
                            {"Re h₂₂", rotary ? "rad/(N·m·s)" : "m/(N·s)"}, "h22_real");
  choose_scale(second);
  Panel third = make_panel(parts, "Condition 3: 2 Re h₁₁ Re h₂₂ − |h₁₂h₂₁| − Re(h₁₂h₂₁) ≥ 0",
                           {"left side", ""}, "margin");
  show_around_zero(third);
  Figure figure{figure_title(result, "Two-port"), {first, second, third}};
  Panel felt =
      make_panel(parts, "Transparency: felt over environment", {"|Zₜₑ/Zₑ|", ""}, "transparency");
  const bool comparable = std::any_of(felt.curves.begin(), felt.curves.end(), [](const Curve& c) {
    return std::any_of(c.y.begin(), c.y.end(), [](double y) { return std::isfinite(y); });
  });
  if (comparable) {
    felt.lines = {{1, false}};
  } else {
    felt = felt_panel(parts, damping);
  }
  felt.y_axis.logarithmic = true;
  figure.panels.push_back(std::move(felt));
  figure.columns = 2;
  figure.panel_width = 560;
  figure.panel_height = 360;
  return figure;
}

}  // namespace gyrator
