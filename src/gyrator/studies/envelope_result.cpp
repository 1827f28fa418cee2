#include "gyrator/studies/envelope_result.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/frequency_grid.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/passivity/impedance_envelope.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/studies/operating_point_fields.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

void require_position_wall(const Model& model) {
  std::string reason;
  if (find_held_impedance(model.device))
    reason = "an analog loop renders it, which has no sampling";
  if (std::holds_alternative<WaveController>(model.controller.law))
    reason = "it lies behind a wave line, where any stiffness is passive";
  if (std::holds_alternative<PredictiveWall>(model.controller.law))
    reason = "it is computed from a predicted position, where it may not be linear in K and B";
  if (reason.empty()) return;
  throw Error(ErrorCode::bad_input, "controller",
              "no envelope of this wall: " + reason +
                  "; an envelope is of walls computed from the sampled position");
}

// The controller as it is, or its wall with each of the cut-offs.
std::vector<Controller> list_controllers(const Model& model, const EnvelopeRequest& request) {
  if (request.cutoff_hz.empty()) return {model.sampled_controller()};
  std::vector<Controller> controllers;
  for (const double cutoff : request.cutoff_hz) {
    VirtualWall wall;
    if (const auto* own = std::get_if<VirtualWall>(&model.controller.law)) wall = *own;
    wall.velocity = FilteredDifferenceEstimator{cutoff};
    controllers.emplace_back(wall, model.controller.wrappers);
  }
  return controllers;
}

struct Band {
  double low, high;  // [Hz]
};

// Checks what the user asked for, too: these errors are not the model's.
Band choose_band(const Model& model, const EnvelopeRequest& request) {
  for (const double cutoff : request.cutoff_hz) {
    if (cutoff > 0) continue;
    throw Error(ErrorCode::bad_input, "--cutoff",
                fmt::format("{:g} Hz: must be above 0 Hz", cutoff));
  }
  // At Nyquist itself the fundamental and its alias are one.
  const double nyquist = 0.5 / model.sampling.period.to_double();
  const double low = request.from_hz.value_or(std::min(1.0, 1e-2 * nyquist));
  const double high = request.to_hz.value_or(nyquist * (1 - 1e-6));
  if (!(low > 0) || !(high > low) || !(high < nyquist)) {
    throw Error(
        ErrorCode::bad_input, "--band",
        fmt::format("{:g} Hz to {:g} Hz: a band lies above 0 Hz and below half the sampling "
                    "frequency, {:g} Hz",
                    low, high, nyquist));
  }
  return {low, high};
}

std::vector<double> list_frequencies(const Band& band, const std::vector<double>& judged) {
  const auto [low, high] = band;
  std::vector<double> frequency{low};
  for (const double omega : judged) {
    const double hertz = omega / (2 * std::numbers::pi);
    if (hertz > low * (1 + 1e-9) && hertz < high * (1 - 1e-9)) frequency.push_back(hertz);
  }
  frequency.push_back(high);
  return frequency;
}

struct Columns {
  std::vector<double> impedance_max, impedance_min, admittance_max, admittance_min, bare;
};

json numbers_or_null(const std::vector<double>& values) {
  json list = json::array();
  for (const double value : values) list.push_back(finite_or_null(value));
  return list;
}

// Which wall has the extreme, as columns.
json walls_of(const std::vector<EnvelopePoint>& envelope, DisplayedExtreme EnvelopePoint::*extreme,
              const std::vector<double>& cutoff_hz) {
  json walls = {{"stiffness", json::array()}, {"damping", json::array()}};
  if (!cutoff_hz.empty()) walls["cutoff_hz"] = json::array();
  for (const auto& point : envelope) {
    walls["stiffness"].push_back((point.*extreme).wall.stiffness);
    walls["damping"].push_back((point.*extreme).wall.damping);
    if (!cutoff_hz.empty()) walls["cutoff_hz"].push_back(cutoff_hz[(point.*extreme).choice]);
  }
  return walls;
}

json region_of(const WallChoice& choice, const std::vector<double>& cutoff_hz, std::size_t index) {
  std::vector<double> stiffness;
  std::vector<double> damping;
  for (const auto& corner : choice.walls.outline) {
    stiffness.push_back(corner.stiffness);
    damping.push_back(corner.damping);
  }
  return {{"cutoff_hz", cutoff_hz.empty() ? json(nullptr) : json(cutoff_hz[index])},
          {"stiffness", stiffness},
          {"damping", damping},
          {"area", choice.walls.area()}};
}

}  // namespace

json make_envelope_result(const Model& model, const EnvelopeRequest& request) {
  const Band band = choose_band(model, request);
  return naming_file(model, [&] {
    require_stable_device(model.device);
    require_position_wall(model);
    std::vector<WallChoice> choices;
    std::vector<double> frequency;
    for (const Controller& controller : list_controllers(model, request)) {
      StiffnessLimits limits(model.device, model.sampling, controller, model.held_by);
      if (frequency.empty()) frequency = list_frequencies(band, limits.grid());
      const LawFamily family(controller, model.sampling.period.to_double());
      choices.push_back({family, trace_passive_walls(limits, family, request.criterion)});
    }
    DisplayedImpedance displayed(model.device, model.sampling);
    const auto envelope = compute_impedance_envelope(displayed, choices, frequency);

    json result = start_result("zwidth-envelope", model);
    Columns columns;
    for (const EnvelopePoint& point : envelope) {
      columns.impedance_max.push_back(point.highest.magnitude);
      columns.impedance_min.push_back(point.lowest.magnitude);
      columns.admittance_max.push_back(1 / point.lowest.magnitude);
      columns.admittance_min.push_back(1 / point.highest.magnitude);
      columns.bare.push_back(point.bare);
    }
    result["criterion"] = name_of(request.criterion);
    result["frequency_hz"] = frequency;
    result["impedance_max"] = numbers_or_null(columns.impedance_max);
    result["impedance_min"] = numbers_or_null(columns.impedance_min);
    result["admittance_max"] = numbers_or_null(columns.admittance_max);
    result["admittance_min"] = numbers_or_null(columns.admittance_min);
    result["bare_impedance"] = columns.bare;
    result["at_impedance_max"] = walls_of(envelope, &EnvelopePoint::highest, request.cutoff_hz);
    result["at_impedance_min"] = walls_of(envelope, &EnvelopePoint::lowest, request.cutoff_hz);
    const EnvelopeAreas areas = compute_envelope_areas(envelope);
    result["areas"] = {{"logarithmic", finite_or_null(areas.logarithmic)},
                       {"impedance", finite_or_null(areas.impedance)},
                       {"admittance", finite_or_null(areas.admittance)}};
    result["regions"] = json::array();
    for (std::size_t i = 0; i < choices.size(); ++i)
      result["regions"].push_back(region_of(choices[i], request.cutoff_hz, i));
    result["operating_point"] = make_operating_point_fields(model);
    return result;
  });
}

namespace {

std::string admittance_unit(const json& result) {
  return unit_of(result, "damping") == "N.s/m" ? "m/(N.s)" : "rad/(N.m.s)";
}

Panel envelope_panel(const json& result, const std::string& quantity, const std::string& title,
                     const std::string& unit) {
  const std::string place = "zwidth-envelope result";
  const auto frequency = required_numbers(result, "frequency_hz", place);
  const auto high = required_numbers(result, quantity + "_max", place);
  const auto low = required_numbers(result, quantity + "_min", place);
  auto bare = required_numbers(result, "bare_impedance", place);
  if (quantity == "admittance") {
    for (double& value : bare) value = 1 / value;
  }
  Panel panel{title, {"frequency", "Hz", true}, {quantity, unit, true}};
  panel.curves = {{"passive walls", frequency, high, CurveStyle::band, Colour::sky, low},
                  {"largest", frequency, high, CurveStyle::line, Colour::blue},
                  {"smallest", frequency, low, CurveStyle::line, Colour::vermillion},
                  {"bare device", frequency, bare, CurveStyle::dashed, Colour::black}};
  return panel;
}

}  // namespace

Figure envelope_figure(const json& result) {
  Figure figure{figure_title(result, "What passive walls can display"),
                {envelope_panel(result, "impedance", "Impedance |Z|", unit_of(result, "damping")),
                 envelope_panel(result, "admittance", "Admittance |1/Z|", admittance_unit(result))},
                2};
  figure.panel_height = 420;
  return figure;
}

ReportSection envelope_section(const json& result) {
  const std::string place = "zwidth-envelope result";
  const auto frequency = required_numbers(result, "frequency_hz", place);
  const auto high = required_numbers(result, "impedance_max", place);
  const auto low = required_numbers(result, "impedance_min", place);
  const auto bare = required_numbers(result, "bare_impedance", place);
  const auto count = std::min({frequency.size(), high.size(), low.size(), bare.size()});
  if (count == 0) return {"Z-width over frequency", html_paragraph("No frequencies."), {}};
  const std::string unit = unit_of(result, "damping");
  std::vector<std::vector<HtmlCell>> rows;
  for (const double hertz : {1.0, 10.0, 100.0, 1000.0}) {
    const auto at = std::lower_bound(frequency.begin(), frequency.end(), hertz * (1 - 1e-9));
    if (at == frequency.end()) continue;
    const auto i = static_cast<std::size_t>(at - frequency.begin());
    if (i >= count) continue;
    rows.push_back({{pretty_frequency(frequency[i]), "number"},
                    {pretty_quantity(low[i], unit), "number"},
                    {pretty_quantity(bare[i], unit), "number"},
                    {pretty_quantity(high[i], unit), "number"}});
  }
  const json& areas = required(result, "areas", place);
  const std::string words = fmt::format(
      "Between smallest and largest lie {} decades of impedance times decades of frequency.",
      pretty_number(optional_number(areas, "logarithmic")));
  return {"Z-width over frequency",
          html_table({"Frequency", "Smallest |Z|", "Bare device", "Largest |Z|"}, rows) +
              html_paragraph(words),
          "The smallest and the largest impedance that the hand can be shown at each frequency by "
          "walls that are passive, and the same as admittance. A wall may ring lower than the bare "
          "device where its spring cancels the inertia."};
}

}  // namespace gyrator
