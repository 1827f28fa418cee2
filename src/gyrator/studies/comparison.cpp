#include "gyrator/studies/comparison.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/passivity/port_response.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"
#include "gyrator/studies/progress.hpp"
#include "gyrator/version.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <boost/math/tools/minima.hpp>
#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr double slow_hz = 1;
constexpr double fast_hz = 100;

// A range that feasibility does not end is cut here, as a multiple of the device's own damping.
constexpr double widest_range = 1e9;
constexpr double narrowest_range = 1e-9;

json finite_or_null(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

StiffnessLimits make_limits(const Model& model) {
  return {model.device, model.sampling, model.sampled_controller(), model.held_by};
}

Device in_free_air(Device device) {
  std::erase_if(device.drive.damping,
                [](const Damping& d) { return std::holds_alternative<HeldImpedance>(d); });
  return device;
}

struct Design {
  const Model* model;
  StiffnessLimits limits;
  double widest_damping = 0;  // beyond which no stiffness is passive; infinite if nothing bounds it
  std::vector<double> damping;
  std::vector<StiffnessLimit> found;
  double best_damping = 0, best_stiffness = 0;
};

// Analyses know keys, not files.
Design start_design(const Model& model) {
  try {
    require_stable_device(model.device);
    return {&model, make_limits(model), 0, {}, {}};
  } catch (const Error& error) {
    throw Error(error.code(), model.file + ": /" + error.place(), error.message());
  }
}

double find_widest_damping(StiffnessLimits& limits) {
  const auto feasible = [&](double damping) {
    return limits.find(Criterion::exact_disk, damping).feasible;
  };
  const double b =
      std::max(limits.disk().model().at(limits.grid().front()).impedance.real(), 1e-12);
  if (!feasible(0)) return 0;
  double low = 0;
  double high = b;
  while (feasible(high)) {
    low = high;
    high *= 2;
    if (high > widest_range * b) return INFINITY;
  }
  while (high - low > 1e-4 * high && high > narrowest_range * b) {
    const double middle = (low + high) / 2;
    (feasible(middle) ? low : high) = middle;
  }
  return low;
}

// Zero, then a logarithmic range.
std::vector<double> make_range(double from, double to, int points) {
  std::vector<double> range{0};
  for (int i = 0; i < points - 1; ++i)
    range.push_back(from * std::pow(to / from, i / std::max(1.0, points - 2.0)));
  return range;
}

json felt_json(const Device& device) {
  const auto responses = compute_port_response(in_free_air(device), {slow_hz, fast_hz});
  return {{"damping_1hz", responses[0].impedance.real()},
          {"damping_100hz", responses[1].impedance.real()},
          {"apparent_inertia", responses[0].impedance.imag() / responses[0].omega}};
}

// The same design with another winding temperature: what is left at the virtual damping that was
// best.
json at_temperature(const Model& nominal, double step, double damping) {
  Model model = nominal;
  json result = {{"temperature_rise", nullptr},
                 {"stable", true},
                 {"max_stiffness", nullptr},
                 {"damping_100hz", nullptr}};
  if (model.device.drive.motor) model.device.drive.motor->temperature_rise += step;
  if (model.device.drive.motor && !(model.device.drive.motor->warm_resistance() > 0)) {
    result["stable"] = false;
    return result;
  }
  result["temperature_rise"] =
      model.device.drive.motor ? json(model.device.drive.motor->temperature_rise) : json(nullptr);
  try {
    require_stable_device(model.device);
  } catch (const Error&) {
    result["stable"] = false;
    return result;
  }
  const StiffnessLimit limit = make_limits(model).find(Criterion::exact_disk, damping);
  result["max_stiffness"] = finite_or_null(limit.stiffness);
  result["damping_100hz"] = felt_json(model.device)["damping_100hz"];
  return result;
}

// The largest stiffness; between the points of a range as well, so that it does not hang on them.
void find_best(Design& design, bool refine) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < design.found.size(); ++i) {
    if (design.found[i].stiffness > design.found[best].stiffness) best = i;
  }
  design.best_damping = design.damping[best];
  design.best_stiffness = design.found[best].stiffness;
  const bool inside = best > 0 && best + 1 < design.damping.size();
  if (!refine || !inside || !std::isfinite(design.best_stiffness)) return;
  constexpr int bits = 12;
  std::uintmax_t most = 20;
  const auto [damping, lowest] = boost::math::tools::brent_find_minima(
      [&](double b) { return -design.limits.find(Criterion::exact_disk, b).stiffness; },
      design.damping[best - 1], design.damping[best + 1], bits, most);
  if (-lowest <= design.best_stiffness) return;
  design.best_damping = damping;
  design.best_stiffness = -lowest;
}

json design_json(const Design& design, double temperature_step) {
  const Model& model = *design.model;
  json stiffness = json::array();
  json feasible = json::array();
  for (const StiffnessLimit& limit : design.found) {
    stiffness.push_back(finite_or_null(limit.stiffness));
    feasible.push_back(limit.feasible);
  }
  const double best_damping = design.best_damping;
  json result = {
      {"name", model.name},
      {"file", model.file},
      {"damping", design.damping},
      {"max_stiffness", stiffness},
      {"feasible", feasible},
      {"best",
       {{"damping", best_damping}, {"max_stiffness", finite_or_null(design.best_stiffness)}}}};
  result.update(felt_json(model.device));
  result["colder"] = at_temperature(model, -temperature_step, best_damping);
  result["warmer"] = at_temperature(model, temperature_step, best_damping);
  return result;
}

void check_motion(const std::vector<Model>& models) {
  for (const Model& model : models) {
    if (model.device.motion == models.front().device.motion) continue;
    throw Error(ErrorCode::bad_input, model.file + ": /motion",
                fmt::format("differs from that of {}: only designs of the same motion can be "
                            "compared",
                            models.front().file));
  }
}

}  // namespace

json make_comparison_result(const std::vector<Model>& models, const ComparisonRequest& request) {
  check_motion(models);
  std::vector<Design> designs;
  double widest = 0;
  double narrowest = INFINITY;
  Progress progress("compare", models.size() * 3, request.quiet);
  for (const Model& model : models) {
    throw_if_interrupted("compare");
    Design design = start_design(model);
    if (request.damping.empty()) design.widest_damping = find_widest_damping(design.limits);
    if (std::isfinite(design.widest_damping)) widest = std::max(widest, design.widest_damping);
    if (design.widest_damping > 0) narrowest = std::min(narrowest, design.widest_damping);
    designs.push_back(std::move(design));
    progress.advance();
  }
  json result = {{"schema", "gyrator/result/1"},
                 {"command", "compare"},
                 {"program", fmt::format("gyrator {}", version)},
                 {"model_name", fmt::format("{} designs", models.size())},
                 {"units", unit_names(models.front().device.motion)},
                 {"temperature_step", request.temperature_step},
                 {"designs", json::array()}};
  for (Design& design : designs) {
    throw_if_interrupted("compare");
    design.damping = request.damping;
    if (request.damping.empty()) {
      // What nothing bounds is shown as far as the others; what is never passive at zero alone.
      const double to = std::isfinite(design.widest_damping) ? design.widest_damping : widest;
      const double from = std::min(narrowest, to) / 100;
      design.damping = to > 0 ? make_range(from, to, request.points) : std::vector<double>{0};
    }
    for (const double damping : design.damping)
      design.found.push_back(design.limits.find(Criterion::exact_disk, damping));
    find_best(design, request.damping.empty());
    progress.advance();
    result["designs"].push_back(design_json(design, request.temperature_step));
    progress.advance();
  }
  return result;
}

}  // namespace gyrator
