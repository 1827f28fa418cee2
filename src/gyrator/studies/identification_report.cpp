#include "gyrator/core/error.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/identification_result.hpp"
#include "gyrator/studies/result_fields.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {

using nlohmann::json;

namespace {

constexpr const char* place = "identify result";
using Numbers = std::vector<double>;

struct Curves {
  Numbers frequency, real, imag, fitted_real, fitted_imag;
};

Curves read_curves(const json& result, const std::string& name) {
  const json& sines = required(result, "sines", place);
  return {required_numbers(sines, "frequency_hz", place),
          required_numbers(sines, name + "_real", place),
          required_numbers(sines, name + "_imag", place),
          required_numbers(sines, "fitted_" + name + "_real", place),
          required_numbers(sines, "fitted_" + name + "_imag", place)};
}

Numbers combine(const Numbers& a, const Numbers& b, double (*make)(double, double)) {
  Numbers values;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) values.push_back(make(a[i], b[i]));
  return values;
}

double find_size(double a, double b) {
  return std::hypot(a, b);
}

double find_degrees(double re, double im) {
  return std::atan2(im, re) * 180 / std::numbers::pi;
}

bool is_known(const Numbers& values) {
  return std::any_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

Panel make_panel(const Curves& c, const std::string& title, const Axis& axis,
                 double (*make)(double, double)) {
  Panel panel{title, {"frequency", "Hz", true}, axis};
  panel.curves = {
      {"measured", c.frequency, combine(c.real, c.imag, make), CurveStyle::points, Colour::blue},
      {"fit", c.frequency, combine(c.fitted_real, c.fitted_imag, make), CurveStyle::dashed,
       Colour::black}};
  return panel;
}

// What is left, per size of the measured.
Panel make_residual_panel(const Curves& c, const std::string& title) {
  Numbers in_phase, across;
  for (std::size_t i = 0; i < c.frequency.size(); ++i) {
    const std::complex<double> measured(c.real[i], c.imag[i]);
    const std::complex<double> off =
        1000.0 * (measured / std::complex<double>(c.fitted_real[i], c.fitted_imag[i]) - 1.0);
    in_phase.push_back(off.real());
    across.push_back(off.imag());
  }
  Panel panel{title, {"frequency", "Hz", true}, {"measured / fit − 1", "10⁻³"}};
  panel.curves = {{"in size", c.frequency, in_phase, CurveStyle::points, Colour::blue},
                  {"in phase", c.frequency, across, CurveStyle::points, Colour::orange}};
  panel.lines = {{0, false}};
  return panel;
}

Panel make_friction_panel(const json& result, const json& friction) {
  const Numbers velocity = required_numbers(friction, "velocity", place);
  const double damping = required_number(friction, "damping", place);
  const double dry = required_number(friction, "coulomb_friction", place);
  const double top = velocity.empty() ? 1 : *std::max_element(velocity.begin(), velocity.end());
  const double bottom = velocity.empty() ? -1 : *std::min_element(velocity.begin(), velocity.end());
  Panel panel{"Friction: effort less inertia",
              {"velocity", unit_of(result, "velocity")},
              {"effort", unit_of(result, "effort")}};
  panel.curves = {{"measured", velocity, required_numbers(friction, "effort", place),
                   CurveStyle::points, Colour::blue},
                  {"viscous and Coulomb",
                   {bottom, 0, NAN, 0, top},
                   {bottom * damping - dry, -dry, NAN, dry, top * damping + dry},
                   CurveStyle::line,
                   Colour::vermillion}};
  panel.lines = {{0, false}, {0, true}};
  return panel;
}

Panel make_friction_residual_panel(const json& result, const json& friction) {
  const Numbers velocity = required_numbers(friction, "velocity", place);
  Numbers rest = required_numbers(friction, "effort", place);
  const double damping = required_number(friction, "damping", place);
  const double dry = required_number(friction, "coulomb_friction", place);
  for (std::size_t i = 0; i < std::min(rest.size(), velocity.size()); ++i)
    rest[i] -= damping * velocity[i] + std::copysign(dry, velocity[i]);
  Panel panel{"… and what the fit leaves",
              {"velocity", unit_of(result, "velocity")},
              {"residual", unit_of(result, "effort")}};
  panel.curves = {{"", velocity, rest, CurveStyle::points, Colour::blue}};
  panel.lines = {{0, false}};
  return panel;
}

}  // namespace

Figure identification_figure(const json& result) {
  Figure figure{figure_title(result, "Identification"), {}};
  if (const Curves c = has(result, "sines") ? read_curves(result, "impedance") : Curves{};
      is_known(c.real)) {
    figure.panels.push_back(make_panel(c, "Terminals: V/I", {"|V/I|", "Ω", true}, find_size));
    figure.panels.push_back(make_panel(c, "… its phase", {"phase", "degrees"}, find_degrees));
    figure.panels.push_back(make_residual_panel(c, "… and what the fit leaves"));
  }
  if (const Curves c = has(result, "sines") ? read_curves(result, "current") : Curves{};
      is_known(c.real) && is_known(c.fitted_real)) {
    figure.panels.push_back(
        make_panel(c, "Amplifier: current per command", {"phase", "degrees"}, find_degrees));
  }
  if (has(result, "friction")) {
    figure.panels.push_back(make_friction_panel(result, result["friction"]));
    figure.panels.push_back(make_friction_residual_panel(result, result["friction"]));
  }
  if (figure.panels.empty())
    throw Error(ErrorCode::bad_input, place, "nothing was measured that could be drawn");
  figure.columns = figure.panels.size() > 1 ? 2 : 1;
  return figure;
}

ReportSection identification_section(const json& result) {
  std::vector<std::vector<HtmlCell>> rows;
  for (const json& p : required_array(result, "parameters", place)) {
    const std::string unit = optional_text(p, "unit");
    const auto cell = [&](const char* key) {
      return HtmlCell{pretty_quantity(optional_number(p, key), unit, 5), "number"};
    };
    const bool known = optional_flag(p, "identifiable", false);
    rows.push_back({{optional_text(p, "name")},
                    cell("value"),
                    cell("low"),
                    cell("high"),
                    {known ? "yes" : "no", known ? "yes" : "no"},
                    {optional_text(p, "note")}});
  }
  std::string html = html_paragraph(identification_sentence(result));
  if (!rows.empty())
    html += html_table({"Parameter", "Value", "99 % from", "to", "Identifiable", "Remark"}, rows);
  return {"Identification of the motor", html,
          "Terminal impedance and amplifier from stepped sines, up and down again; friction from "
          "slow sines, each point the mean of a stretch in which the motor does not turn back."};
}

std::string identification_sentence(const json& result) {
  if (optional_text(result, "outcome") == "planned") return "Nothing was measured: only planned.";
  int known = 0, all = 0;
  std::string unknown;
  for (const json& p : required_array(result, "parameters", place)) {
    ++all;
    if (optional_flag(p, "identifiable", false)) {
      ++known;
    } else {
      unknown += (unknown.empty() ? "" : ", ") + optional_text(p, "name");
    }
  }
  return fmt::format("{} of {} parameters were identified in {:.3g} s of experiments{}.", known,
                     all, optional_number(result, "duration_s"),
                     unknown.empty() ? "" : "; not identifiable: " + unknown);
}

}  // namespace gyrator
