#include "gyrator/studies/results.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/minimum_mass.hpp"
#include "gyrator/passivity/port_response.hpp"
#include "gyrator/studies/operating_point_fields.hpp"
#include "gyrator/studies/progress.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

json optional_number(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

json criterion_json(const CriterionResult& c) {
  return {{"name", c.name},
          {"applies", c.applies},
          {"holds", c.holds},
          {"margin", finite_or_null(c.margin)},
          {"worst_frequency_hz", optional_number(c.worst_frequency_hz)},
          {"max_stiffness", c.max_stiffness ? finite_or_null(*c.max_stiffness) : json(nullptr)},
          {"reason", c.reason}};
}

json disk_json(const Verdict& v) {
  const DiskPoint& d = v.shown_disk;
  const std::complex<double> critical = -1.0 / v.shown_law;
  return {{"frequency_hz", d.omega / (2 * std::numbers::pi)},
          {"center_real", finite_or_null(d.center.real())},
          {"center_imag", finite_or_null(d.center.imag())},
          {"radius", finite_or_null(d.radius)},
          {"critical_real", finite_or_null(critical.real())},
          {"critical_imag", finite_or_null(critical.imag())}};
}

constexpr double most_samples = 4e6;  // of a counterexample's run, about a second

// Whether a run of that many samples can show the growth: 2 % are divergence.
bool can_be_seen(const Counterexample& found) {
  return std::log(found.spectral_radius) * most_samples > 0.1;
}

// A run of the loop with the operator that lasts until the growth is plain to see.
json simulate_counterexample(const Model& model, const Controller& controller,
                             const Counterexample& found) {
  constexpr double wanted_growth = 8;  // natural logarithm: a factor of 3000
  constexpr double rows = 4000;
  const double rate = std::log(found.spectral_radius);
  const double period = model.sampling.period.to_double();
  // At least ten periods of the oscillation, at most what takes a second.
  const double oscillation = found.frequency_hz > 0 ? 10 / (found.frequency_hz * period) : 0;
  const auto samples = static_cast<std::int64_t>(
      std::clamp(std::max(wanted_growth / rate, oscillation), 60.0, most_samples));
  SimulationOptions options;
  options.duration = model.sampling.period * Rational(samples);
  options.initial_velocity = model.initial_velocity != 0 ? model.initial_velocity : 1e-3;
  options.initial_position = model.initial_position;
  options.engine_options.ledger = false;
  options.record_every =
      std::max<long>(1, static_cast<long>(std::floor(static_cast<double>(samples) / rows)));
  // The loop that the verdict is about: the wall in contact, nothing quantized.
  const Plant plant = build_plant(build_device_network(model.device, found.held_by));
  const TimeRun run = simulate(plant, Sensor{}, controller, model.sampling, options);
  return {{"classification", name_of(run.classification.outcome)},
          {"duration_s", run.final_time_s},
          {"samples", run.steps},
          {"initial_velocity", options.initial_velocity},
          {"time_s", run.trace.column("time_s")},
          {"position", run.trace.column("position")},
          {"command", run.trace.column("command")}};
}

json counterexample_json(const Model& model, const Verdict& verdict, bool with_run) {
  const Counterexample& found = *verdict.counterexample;
  json resonators = json::array();
  for (const auto& r : found.held_by.resonators) {
    resonators.push_back({{"inertia", r.inertia}, {"stiffness", r.stiffness}});
  }
  json result = {{"inertia", found.held_by.inertia},
                 {"stiffness", found.held_by.stiffness},
                 {"resonators", resonators},
                 {"spectral_radius", found.spectral_radius},
                 {"frequency_hz", found.frequency_hz}};
  if (with_run && can_be_seen(found))
    result["simulation"] = simulate_counterexample(model, verdict.judged, found);
  return result;
}

// What is proved between the points of the curves.
json proof_json(const DiskProof& proof) {
  constexpr std::array<const char*, 3> outcomes{"proved", "violated", "undecided"};
  return {{"outcome", outcomes[static_cast<std::size_t>(proof.outcome)]},
          {"intervals", proof.intervals.size()},
          {"lowest_margin",
           proof.outcome == ProofOutcome::proved ? finite_or_null(proof.margin) : json(nullptr)},
          {"frequency_hz", proof.outcome == ProofOutcome::proved
                               ? json(nullptr)
                               : json(proof.omega / (2 * std::numbers::pi))}};
}

// Of a virtual coupling's tool, by each integration scheme; null where no mass is passive.
json minimum_mass_json(const Model& model) {
  json masses = json::object();
  for (const auto kind :
       {Integration::explicit_euler, Integration::semi_implicit, Integration::implicit})
    masses[name_of(kind)] = optional_number(find_minimum_mass(model.passivity_model(), kind));
  const auto& coupling = std::get<VirtualCoupling>(model.controller.law);
  masses["chosen"] = masses[name_of(coupling.integration)];
  masses["tool"] = coupling.tool_inertia;
  return masses;
}

// Where an analog loop does the wall, no estimator is left to judge.
StiffnessLimits make_limits(const Model& model) {
  return naming_file(model, [&] {
    return StiffnessLimits(model.device, model.sampling, model.sampled_controller(), model.held_by);
  });
}

json edge_json(const StabilityEdge& edge) {
  return {{"cancellation", optional_number(edge.cancellation)},
          {"coldest_rise", optional_number(edge.coldest_rise)},
          {"hottest_rise", optional_number(edge.hottest_rise)}};
}

// How far a drive that cancels its winding is from oscillating; null for any other.
json stability_json(const Model& model) {
  const auto edges = find_stability_edges(model.device);
  if (!edges) return nullptr;
  return {{"clamped", edge_json(edges->clamped)}, {"free", edge_json(edges->free)}};
}

std::optional<WallValues> wall_of(const Model& model) {
  return find_wall_values(model.controller);
}

// One boundary per criterion.
json make_boundaries(const Model& model, const ZwidthRequest& request) {
  StiffnessLimits limits = make_limits(model);
  Progress progress("Z-width", request.damping.size() * request.criteria.size(), request.quiet);
  json boundaries = json::array();
  for (const Criterion criterion : request.criteria) {
    json stiffness = json::array();
    json feasible = json::array();
    json frequency = json::array();
    for (const double damping : request.damping) {
      throw_if_interrupted("zwidth");
      const StiffnessLimit limit =
          naming_file(model, [&] { return limits.find(criterion, damping); });
      stiffness.push_back(finite_or_null(limit.stiffness));
      feasible.push_back(limit.feasible);
      frequency.push_back(limit.worst_frequency_hz);
      progress.advance();
    }
    boundaries.push_back({{"criterion", name_of(criterion)},
                          {"damping", request.damping},
                          {"max_stiffness", stiffness},
                          {"feasible", feasible},
                          {"worst_frequency_hz", frequency}});
  }
  return boundaries;
}

}  // namespace

json make_impedance_result(const Model& model, const std::vector<double>& frequency_hz) {
  naming_file(model, [&] { require_stable_device(model.device); });
  json result = start_result("impedance", model);
  std::vector<double> z_real;
  std::vector<double> z_imag;
  std::vector<double> a_real;
  std::vector<double> a_imag;
  for (const auto& r : compute_port_response(model.device, frequency_hz)) {
    z_real.push_back(r.impedance.real());
    z_imag.push_back(r.impedance.imag());
    a_real.push_back(r.actuation.real());
    a_imag.push_back(r.actuation.imag());
  }
  result["frequency_hz"] = frequency_hz;
  result["effective_damping"] = z_real;
  result["impedance_real"] = std::move(z_real);
  result["impedance_imag"] = std::move(z_imag);
  result["actuation_real"] = std::move(a_real);
  result["actuation_imag"] = std::move(a_imag);
  result["stability_edges"] = stability_json(model);
  result["operating_point"] = make_operating_point_fields(model);
  return result;
}

json make_passivity_result(const Model& model, const PassivityRequest& request) {
  return answer_passivity(model, request).result;
}

PassivityAnswer answer_passivity(const Model& model, const PassivityRequest& request) {
  Verdict v = naming_file(model, [&] {
    return judge_passivity(model.passivity_model(), request.search_counterexample);
  });
  json result = start_result("passivity", model);
  result["verdict"] = v.passive ? "passive" : "not_passive";
  result["explanation"] = v.explanation;
  if (const auto wall = wall_of(model)) {
    result["stiffness"] = wall->stiffness;
    result["virtual_damping"] = wall->damping;
  }
  const bool reads_wave = std::holds_alternative<WaveController>(model.controller.law);
  result["sampled_signal"] = reads_wave ? "wave_integral" : "position";
  if (std::holds_alternative<VirtualCoupling>(model.controller.law))
    result["minimum_mass"] = minimum_mass_json(model);
  result["criteria"] = json::array();
  for (const auto& criterion : v.criteria) result["criteria"].push_back(criterion_json(criterion));
  result["extra_damping"] = optional_number(v.extra_damping);
  result["device"] = {{"passive", v.device_passive},
                      {"least_damping", v.least_damping},
                      {"least_damping_frequency_hz", v.least_damping_frequency_hz}};
  result["stability_edges"] = stability_json(model);
  result["operating_point"] = make_operating_point_fields(model);
  result["uncoupled_spectral_radius"] = v.loops.front().uncoupled_spectral_radius;
  result["damping_over_frequency"] = {{"frequency_hz", v.curves.frequency_hz},
                                      {"physical", v.curves.physical},
                                      {"virtual", v.curves.virtual_damping},
                                      {"total", v.curves.total},
                                      {"exact", v.curves.exact}};
  if (std::abs(v.shown_law) > 0) result["disk"] = disk_json(v);
  result["counterexample"] = v.counterexample
                                 ? counterexample_json(model, v, request.simulate_counterexample)
                                 : json(nullptr);
  result["proof"] = proof_json(v.loops.front().proof);
  return {std::move(v), std::move(result)};
}

std::vector<double> choose_damping_range(const Model& model, int points) {
  // Behind a wave line every B >= 0 is passive, and none below -b_w has a law.
  if (const auto* wave = std::get_if<WaveController>(&model.controller.law)) {
    std::vector<double> damping;
    for (int i = 0; i < points; ++i)
      damping.push_back(wave->impedance * (-0.5 + 2.0 * i / std::max(1, points - 1)));
    return damping;
  }
  StiffnessLimits limits = make_limits(model);
  const double b = limits.disk().model().at(limits.grid().front()).impedance.real();
  const auto feasible = [&](double damping) {
    return naming_file(model, [&] { return limits.find(Criterion::exact_disk, damping).feasible; });
  };
  // Upwards until the exact disk allows no stiffness any more.
  double high = std::max(b, 1e-12);
  double low = 0;
  for (int i = 0; i < 24 && feasible(high); ++i) {
    low = high;
    high *= 2;
  }
  for (int i = 0; i < 20; ++i) {
    const double middle = (low + high) / 2;
    (feasible(middle) ? low : high) = middle;
  }
  std::vector<double> damping;
  // Nine digits: b is known to rounding, and people read these.
  for (int i = 0; i < points; ++i) {
    const double exact = -b + (high + b) * i / std::max(1, points - 1);
    damping.push_back(std::stod(fmt::format("{:.9g}", exact)));
  }
  return damping;
}

json make_zwidth_result(const Model& model, const ZwidthRequest& request) {
  naming_file(model, [&] { require_stable_device(model.device); });
  json result = start_result("zwidth", model);
  const auto wall = wall_of(model);
  json boundaries = json::array();
  if (!request.criteria.empty()) boundaries = make_boundaries(model, request);
  if (request.time) boundaries.push_back(make_time_boundary(model, *request.time));
  for (const char* key : {"criterion", "damping", "max_stiffness", "feasible"})
    result[key] = boundaries.front()[key];
  result["boundaries"] = std::move(boundaries);
  result["operating_point"] = make_operating_point_fields(model);
  if (wall) result["point"] = {{"damping", wall->damping}, {"stiffness", wall->stiffness}};
  return result;
}

json make_spice_result(const Model& model, const SpiceDeck& deck,
                       const std::optional<std::vector<SpiceDeviation>>& check) {
  json result = start_result("spice", model);
  result["netlist"] = deck.text;
  result["impedance_file"] = deck.impedance_file;
  result["motion_file"] = deck.motion_file;
  result["final_time_s"] = deck.run.final_time_s;
  if (!check) return result;
  bool agrees = true;
  json deviations = json::array();
  for (const auto& d : *check) {
    agrees = agrees && d.agrees();
    deviations.push_back({{"quantity", d.quantity},
                          {"worst", finite_or_null(d.worst)},
                          {d.over_time ? "time_s" : "frequency_hz", d.at},
                          {"tolerance", d.tolerance},
                          {"agrees", d.agrees()}});
  }
  result["agrees"] = agrees;
  result["deviations"] = std::move(deviations);
  return result;
}

}  // namespace gyrator
