#include "gyrator/synthesis/design_problem.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/mechanics/stability.hpp"
#include "gyrator/passivity/port_response.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr double at_rest_hz = 1e-3;  // far below the corner of any circuit
const std::vector<double> slow_hz{at_rest_hz, 0.1, 0.5, 1, 2, 3, 4, 5};
constexpr double no_limit = 1e300;
// What a proof may leave of the grid's limit, so that what the search takes holds when proved.
constexpr double proof_share = 0.999;

double inertia_of(const PortResponse& response) {
  return response.impedance.imag() / response.omega;
}

std::vector<DesignRange> ranges_of(const DesignOption& option) {
  std::vector<DesignRange> ranges;
  for (const SoughtValue& value : option.values) ranges.push_back(value.range);
  return ranges;
}

double period_of(const DesignSpec& spec) {
  return spec.model.sampling.period.to_double();
}

// Of all that is rigid with the port at slow motion: no amplifier or circuit in parallel.
double find_rigid_inertia(Device device) {
  device.drive.amplifier = IdealDrive{};
  return inertia_of(compute_port_response(device, {at_rest_hz}).front());
}

}  // namespace

DesignProblem::DesignProblem(const DesignSpec& spec, const DesignOption& option)
    : spec_(spec),
      option_(option),
      stage_(spec.model, option),
      rigid_inertia_(find_rigid_inertia(spec.model.device)) {
  std::vector<nlohmann::json> middle;
  for (const auto& [low, high] : ranges_of(option)) middle.emplace_back(std::sqrt(low * high));
  device_ = parse_model(make_designed_model(spec, option, middle), spec.model.file).device;
  const double own = device_.drive.motor->temperature_rise;
  rises_ = {own};
  if (spec.winding_rise) {
    for (const double rise : {spec.winding_rise->low, spec.winding_rise->high})
      if (rise != own) rises_.push_back(rise);
  }
  for (const DesignConstraint& constraint : spec.constraints)
    needs_extremes_ = needs_extremes_ || constraint.figure->is_extreme;
}

std::vector<std::vector<double>> DesignProblem::lattice() const {
  constexpr int digits_of_settings = 3;
  constexpr int digits_of_cutoffs = 2;
  std::vector<std::vector<double>> lattice;
  for (std::size_t i = 0; i < size(); ++i) {
    const SoughtValue& variable = option_.values[i];
    const auto [low, high] = variable.range;
    if (variable.part == DesignPart::setting || !spec_.series) {
      const bool is_cutoff = variable.name == velocity_cutoff_name;
      lattice.push_back(
          list_rounded_values(is_cutoff ? digits_of_cutoffs : digits_of_settings, low, high));
    } else if (variable.part == DesignPart::capacitor && !spec_.bipolar_capacitor) {
      lattice.push_back(list_preferred_values(*spec_.series, 2 * low, 2 * high));
      for (double& value : lattice.back()) value /= 2;
    } else {
      lattice.push_back(list_preferred_values(*spec_.series, low, high));
    }
    if (!lattice.back().empty()) continue;
    throw Error(
        ErrorCode::bad_input, fmt::format("{}: /ranges/{}", spec_.file, variable.name),
        fmt::format("{} to {}: no value of {} lies between: widen the range or take another series",
                    format_quantity(low, variable.unit), format_quantity(high, variable.unit),
                    spec_.series ? name_of(*spec_.series) : "three digits"));
  }
  return lattice;
}

Device DesignProblem::make_device(std::span<const double> values) const {
  Device device = device_;
  device.drive.damping.back() = option_.topology->make(*device.drive.motor, values);
  return device;
}

DesignFigures DesignProblem::evaluate(std::span<const double> values, LimitPrecision precision,
                                      const DesignConstraint* free) const {
  throw_if_interrupted("design");
  DesignFigures worst;
  const Device own = make_device(values);
  const Controller controller = make_controller(own, values);
  for (std::size_t i = 0; i < rises_.size(); ++i) {
    Device device = own;
    device.drive.motor->temperature_rise = rises_[i];
    if (!(device.drive.motor->warm_resistance() > 0)) return {};
    DesignFigures figures = evaluate_port(device, controller);
    if (precision == LimitPrecision::on_grid && misses_any(figures, free)) {
      figures.stable = true;  // not known; its merit is as low
      return figures;
    }
    if (precision == LimitPrecision::proved)  // a design's parts are bought by them
      figures.extremes = find_extremes(device, controller);
    for (const Operator& held_by : {Operator(FreeOperator{}), Operator(ClampedOperator{})})
      if (find_unstable_pole(build_device_network(device, held_by))) return {};
    figures.stable = true;
    figures.has_limits = true;
    add_limits(figures, device, controller, precision);
    if (i == 0) {
      worst = figures;
      continue;
    }
    if (figures.least_stiffness < worst.least_stiffness)
      worst.worst_frequency_hz = figures.worst_frequency_hz;
    worst.max_stiffness = std::min(worst.max_stiffness, figures.max_stiffness);
    worst.least_stiffness = std::min(worst.least_stiffness, figures.least_stiffness);
    const auto raise = [](double& peak, double value) { peak = std::max(peak, value); };
    raise(worst.apparent_inertia, figures.apparent_inertia);
    raise(worst.damping_below_5_hz, figures.damping_below_5_hz);
    raise(worst.extremes.resistor_power, figures.extremes.resistor_power);
    raise(worst.extremes.capacitor_voltage, figures.extremes.capacitor_voltage);
    raise(worst.extremes.amplifier_voltage, figures.extremes.amplifier_voltage);
    raise(worst.extremes.amplifier_current, figures.extremes.amplifier_current);
  }
  return worst;
}

bool DesignProblem::misses_any(const DesignFigures& figures, const DesignConstraint* free) const {
  return std::any_of(spec_.constraints.begin(), spec_.constraints.end(),
                     [&](const DesignConstraint& constraint) {
                       return &constraint != free && !constraint.figure->is_minimum &&
                              find_violation(constraint, figures) > 0;
                     });
}

// Every frequency bounds the limit, so that a few bound it from above.
double DesignProblem::find_highest_stiffness(const Device& device,
                                             const Controller& controller) const {
  StiffnessLimits limits(device, spec_.model.sampling, controller, FreeOperator{},
                         GridDensity::coarse);
  double sum = 0;
  for (const double damping : spec_.damping)
    sum += proof_share * std::min(limits.find_upper_bound(damping), no_limit);
  return sum / static_cast<double>(spec_.damping.size());
}

std::optional<DesignMerit> DesignProblem::find_merit_above(const DesignMerit& least,
                                                           std::span<const double> values) const {
  const Device own = make_device(values);
  const Controller controller = make_controller(own, values);
  if (least.feasible && own.drive.motor->warm_resistance() > 0) {
    if (misses_any(evaluate_port(own, controller), nullptr)) return std::nullopt;
    if (spec_.objective == DesignObjective::stiffest &&
        find_highest_stiffness(own, controller) <= least.score)
      return std::nullopt;
  }
  const DesignMerit merit = judge(spec_, evaluate(values));
  return least < merit ? std::optional(merit) : std::nullopt;
}

DesignFigures DesignProblem::evaluate_port(const Device& device,
                                           const Controller& controller) const {
  DesignFigures figures;
  const auto slow = compute_port_response(device, slow_hz);
  figures.apparent_inertia = inertia_of(slow.front()) - rigid_inertia_;
  for (const PortResponse& response : slow)
    figures.damping_below_5_hz = std::max(figures.damping_below_5_hz, response.impedance.real());
  figures.emphasis_gain = find_emphasis_gain(controller);
  if (needs_extremes_) figures.extremes = find_extremes(device, controller);
  return figures;
}

OperatingExtremes DesignProblem::find_extremes(const Device& device,
                                               const Controller& controller) const {
  return compute_operating_extremes(device, device.drive.damping.size() - 1, spec_.operation,
                                    {make_output_law(controller), period_of(spec_)});
}

void DesignProblem::add_limits(DesignFigures& figures, const Device& device,
                               const Controller& controller, LimitPrecision precision) const {
  StiffnessLimits limits(device, spec_.model.sampling, controller, FreeOperator{},
                         GridDensity::coarse);
  figures.least_stiffness = no_limit;
  double sum = 0;
  for (const double damping : spec_.damping) {
    const StiffnessLimit limit = precision == LimitPrecision::on_grid
                                     ? limits.find_on_grid(damping)
                                     : limits.find(Criterion::exact_disk, damping);
    double stiffness = limit.feasible ? std::min(limit.stiffness, no_limit) : 0;
    if (precision == LimitPrecision::on_grid) stiffness *= proof_share;
    sum += stiffness;
    if (stiffness >= figures.least_stiffness) continue;
    figures.least_stiffness = stiffness;
    figures.worst_frequency_hz = limit.worst_frequency_hz;
  }
  figures.max_stiffness = sum / static_cast<double>(spec_.damping.size());
}

double find_violation(const DesignConstraint& constraint, const DesignFigures& figures) {
  const double value = constraint.figure->value(figures);
  const double excess = constraint.figure->is_minimum ? constraint.limit / std::max(value, 0.0)
                                                      : std::max(value, 0.0) / constraint.limit;
  // A design at the limit keeps it.
  constexpr double rounding = 1e-9;
  return excess <= 1 + rounding ? 0 : std::min(std::log(excess), hopeless);
}

DesignMerit judge(const DesignSpec& spec, const DesignFigures& figures,
                  const DesignConstraint* free) {
  if (!figures.stable) return {false, -1e6};
  double missing = !figures.has_limits ? 2 * hopeless : figures.least_stiffness > 0 ? 0 : hopeless;
  for (const DesignConstraint& constraint : spec.constraints) {
    const bool known = figures.has_limits || !constraint.figure->is_minimum;
    if (&constraint != free && known) missing += find_violation(constraint, figures);
  }
  if (missing > 0) return {false, -missing};
  if (free) return {true, -find_violation(*free, figures)};
  if (spec.objective == DesignObjective::stiffest) return {true, figures.max_stiffness};
  // Of those that are as light to six digits, the stiffer one.
  const double reserve = std::min(figures.max_stiffness / spec.constraints.front().limit, 2.0);
  return {true, -figures.apparent_inertia + 1e-6 * std::abs(figures.apparent_inertia) * reserve};
}

}  // namespace gyrator
