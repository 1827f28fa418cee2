#include "gyrator/studies/two_port_result.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/studies/result_parts.hpp"
#include "gyrator/two_port/stiffest_coupling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;
using Complex = std::complex<double>;

constexpr std::array condition_names{"Re h11 >= 0", "Re h22 >= 0",
                                     "2 Re h11 Re h22 >= |h12 h21| + Re(h12 h21)"};

std::vector<double> make_sweep(const TwoPortSweep& sweep, double nyquist_hz) {
  const double to = sweep.to_hz.value_or(nyquist_hz);
  const double from = sweep.from_hz.value_or(to / 1000);
  if (!(to <= nyquist_hz * (1 + 1e-9))) {
    throw Error(ErrorCode::bad_input, "--to",
                fmt::format("{:g} Hz: must be at most {:g} Hz, half the rate of what is computed",
                            to, nyquist_hz));
  }
  if (!(from > 0 && from < to)) {
    throw Error(ErrorCode::bad_input, "--from",
                fmt::format("{:g} Hz: must be above 0 Hz and below --to, {:g} Hz", from, to));
  }
  std::vector<double> frequency;
  for (int i = 0; i < sweep.points; ++i)
    frequency.push_back(from * std::pow(to / from, i / std::max(1.0, sweep.points - 1.0)));
  return frequency;
}

// Of Re h11, Re h22 and what the third compares.
std::array<const char*, 3> condition_units(Motion motion) {
  if (motion == Motion::rotary) return {"N.m.s/rad", "rad/(N.m.s)", "1"};
  return {"N.s/m", "m/(N.s)", "1"};
}

json condition_json(const char* name, const char* unit, const ConditionResult& condition) {
  json bands = json::array();
  for (const auto& band : condition.violated) bands.push_back({band.from_hz, band.to_hz});
  return {{"condition", name},
          {"holds", condition.holds},
          {"margin", finite_or_null(condition.margin)},
          {"unit", unit},
          {"worst_frequency_hz", condition.worst_frequency_hz},
          {"violated_hz", std::move(bands)}};
}

void put_verdict(json& part, const TwoPortVerdict& verdict, Motion motion) {
  part["absolutely_stable"] = verdict.absolutely_stable;
  part["conditions"] = json::array();
  for (std::size_t i = 0; i < condition_names.size(); ++i)
    part["conditions"].push_back(
        condition_json(condition_names[i], condition_units(motion)[i], verdict.conditions[i]));
  part["third_ratio"] = {{"lowest", finite_or_null(verdict.ratio)},
                         {"worst_frequency_hz", verdict.ratio_frequency_hz}};
  part["least_felt_damping"] = {{"value", finite_or_null(verdict.felt)},
                                {"worst_frequency_hz", verdict.felt_frequency_hz}};
  part["computed_spectral_radius"] = finite_or_null(verdict.computed_spectral_radius);
}

// What there is over frequency. An infinite environment is a clamped port; none leaves the
// transparency out.
struct Sweeper {
  std::function<HybridMatrix(double)> port;
  std::function<std::optional<Complex>(double)> environment;
};

void put_sweep(json& part, const Sweeper& sweeper, const std::vector<double>& frequency) {
  for (const char* key :
       {"h11_real", "h11_imag", "h12_real", "h12_imag", "h21_real", "h21_imag", "h22_real",
        "h22_imag", "margin", "transmitted_real", "transmitted_imag", "transparency"})
    part[key] = json::array();
  const auto put = [&](const std::string& name, const Complex& value) {
    part[name + "_real"].push_back(finite_or_null(value.real()));
    part[name + "_imag"].push_back(finite_or_null(value.imag()));
  };
  part["frequency_hz"] = frequency;
  for (const double f : frequency) {
    throw_if_interrupted("twoport");
    const double omega = 2 * std::numbers::pi * f;
    const HybridMatrix h = sweeper.port(omega);
    put("h11", h.h11);
    put("h12", h.h12);
    put("h21", h.h21);
    put("h22", h.h22);
    part["margin"].push_back(finite_or_null(compute_llewellyn_margins(h).third));
    const auto environment = sweeper.environment(omega);
    const bool clamped = environment && std::isinf(environment->real());
    const Complex felt =
        clamped ? h.transmitted_when_clamped() : h.transmitted(environment.value_or(0.0));
    put("transmitted", felt);
    const bool comparable = environment && !clamped && *environment != 0.0;
    part["transparency"].push_back(comparable ? finite_or_null(std::abs(felt / *environment))
                                              : json(nullptr));
  }
}

Rendering rendering_of(const std::string& name) {
  std::vector<std::string> known;
  for (const auto rendering :
       {Rendering::direct, Rendering::proxy, Rendering::equivalent_impedance}) {
    if (name == name_of(rendering)) return rendering;
    known.emplace_back(name_of(rendering));
  }
  throw Error(ErrorCode::bad_input, "--rendering", describe_unknown_name("rendering", name, known));
}

// By what the computer knows of the motion: the velocity as in the published two-ports, and the
// position, as this program's controllers do.
json coupling_limits(const Model& model, const RenderedScene& scene) {
  const SpringDamper own = scene.own == Rendering::proxy ? scene.tool->coupling : *scene.contact;
  json limits = json::array();
  for (const Sensing sensing : {Sensing::velocity, Sensing::position}) {
    throw_if_interrupted("twoport");
    ComputedPath path = scene.path;
    path.sensing = sensing;
    const StiffestCoupling coupling(model.device, path);
    const CouplingLimit limit = coupling.find(own.damping);
    const auto best = coupling.find_best();
    limits.push_back({{"sensing", name_of(sensing)},
                      {"damping", own.damping},
                      {"feasible", limit.feasible},
                      {"max_stiffness", finite_or_null(limit.stiffness)},
                      {"worst_frequency_hz", limit.worst_frequency_hz},
                      {"best", best ? json{{"damping", best->damping},
                                           {"max_stiffness", finite_or_null(best->limit.stiffness)},
                                           {"worst_frequency_hz", best->limit.worst_frequency_hz}}
                                    : json(nullptr)}});
    if (!scene.tool) continue;
    RenderedScene varied = scene;
    varied.path.sensing = sensing;
    const auto with_tool = find_stiffest_proxy_coupling(model.device, varied);
    limits.back()["max_stiffness_with_tool"] = with_tool ? json(*with_tool) : json(nullptr);
  }
  return limits;
}

// Of an operator in the slave's hand: 0 free, infinite clamped, none for a network.
std::optional<Complex> operator_impedance(const Operator& held_by, double omega) {
  if (std::holds_alternative<FreeOperator>(held_by)) return 0.0;
  if (std::holds_alternative<ClampedOperator>(held_by))
    return std::numeric_limits<double>::infinity();
  const auto* hand = std::get_if<MassSpringDamper>(&held_by);
  if (!hand || !hand->resonators.empty()) return std::nullopt;
  const Complex s(0, omega);
  return hand->inertia * s + hand->damping + hand->stiffness / s;
}

ComputedPath path_of(const Model& model, Sensing sensing) {
  ComputedPath path;
  path.period = path.step = path.tick = model.sampling.period.to_double();
  path.delay = model.sampling.delay.to_double();
  path.sensing = sensing;
  return path;
}

}  // namespace

json make_two_port_result(const Model& model, const TwoPortRequest& request) {
  naming_file(model, [&] { require_stable_device(model.device); });
  RenderedScene scene = naming_file(
      model, [&] { return make_rendered_scene(model.sampled_controller(), model.sampling); });
  scene.path.sensing = request.sensing;
  scene.passivity_damping = request.passivity_damping;
  RenderingPort port(model.device, scene);
  std::vector<Rendering> renderings;
  for (const auto& name : request.renderings) renderings.push_back(rendering_of(name));
  if (renderings.empty()) renderings.push_back(scene.own);
  if (request.passivity_damping > 0 &&
      std::find(renderings.begin(), renderings.end(), Rendering::direct) == renderings.end()) {
    throw Error(ErrorCode::bad_input, "--passivity-damping",
                fmt::format("has no part in {} rendering: it belongs to a passivity controller "
                            "around direct rendering, --rendering direct",
                            name_of(renderings.front())));
  }
  for (const Rendering rendering : renderings) naming_file(model, [&] { port.require(rendering); });

  json result = start_result("twoport", model);
  const double nyquist_hz = 0.5 / scene.path.period;
  const auto frequency = make_sweep(request.sweep, nyquist_hz);
  json parts = json::array();
  for (const Rendering rendering : renderings) {
    json part = {{"rendering", name_of(rendering)}};
    put_verdict(part, port.judge(rendering), model.device.motion);
    put_sweep(part,
              {[&](double omega) { return port.at(rendering, omega); },
               [&](double omega) { return port.environment_impedance(omega); }},
              frequency);
    parts.push_back(std::move(part));
  }
  result.update(parts.front());
  result["renderings"] = std::move(parts);
  result["environment_real"] = json::array();
  result["environment_imag"] = json::array();
  for (const double f : frequency) {
    const auto z = port.environment_impedance(2 * std::numbers::pi * f);
    result["environment_real"].push_back(z ? finite_or_null(z->real()) : json(nullptr));
    result["environment_imag"].push_back(z ? finite_or_null(z->imag()) : json(nullptr));
  }
  result["period_s"] = scene.path.period;
  result["delay_s"] = scene.path.delay;
  result["nyquist_hz"] = nyquist_hz;
  result["sensing"] = name_of(scene.path.sensing);
  result["integration"] = name_of(scene.path.integration);
  result["coupling_limits"] = coupling_limits(model, scene);
  return result;
}

json make_remote_result(const Model& master, const Model& slave, const RemoteRequest& request) {
  for (const Model* model : {&master, &slave})
    naming_file(*model, [&] { require_stable_device(model->device); });
  if (master.device.motion != slave.device.motion) {
    throw Error(ErrorCode::bad_input, slave.file + ": /motion",
                "must be that of " + master.file + ": a coupling joins two of a kind");
  }
  CoupledDevices devices = naming_file(slave, [&] {
    return CoupledDevices(
        master.device, path_of(master, request.sensing), slave.device,
        path_of(slave, request.sensing),
        {request.coupling, request.delay_there, request.delay_back, request.place});
  });
  json result = start_result("twoport", master);
  const double period = master.sampling.period.to_double();
  json part = {{"rendering", "remote"}};
  put_verdict(part, devices.judge(), master.device.motion);
  put_sweep(part,
            {[&](double omega) { return devices.at(omega); },
             [&](double omega) { return operator_impedance(slave.held_by, omega); }},
            make_sweep(request.sweep, 0.5 / period));
  result.update(part);
  result["renderings"] = json::array({std::move(part)});
  result["remote"] = {{"name", slave.name},
                      {"model", slave.source},
                      {"stiffness", request.coupling.stiffness},
                      {"damping", request.coupling.damping},
                      {"delay_there_s", request.delay_there},
                      {"delay_back_s", request.delay_back},
                      {"coupling_at", name_of(request.place)}};
  result["period_s"] = period;
  result["nyquist_hz"] = 0.5 / period;
  result["sensing"] = name_of(request.sensing);
  return result;
}

}  // namespace gyrator
