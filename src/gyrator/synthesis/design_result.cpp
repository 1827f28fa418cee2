#include "gyrator/synthesis/design_result.hpp"

#include "gyrator/core/text.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/result_parts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

json values_of(const DesignSpec& spec, const Candidate& candidate) {
  json values = json::object();
  for (std::size_t i = 0; i < candidate.values.size(); ++i)
    values[candidate.option->values[i].name] = candidate.values[i];
  if (mentions_pre_emphasis(spec)) values[pre_emphasis_name] = candidate.option->pre_emphasis;
  return values;
}

json summarize(const DesignSpec& spec, const Candidate& candidate) {
  return {{"topology", candidate.option->topology->name},
          {"values", values_of(spec, candidate)},
          {"max_stiffness", finite_or_null(candidate.figures.max_stiffness)},
          {"apparent_inertia", candidate.figures.apparent_inertia}};
}

json make_bill(const DesignSpec& spec, const Candidate& candidate,
               const OperatingExtremes& extremes) {
  const bool operated = spec.operation.speed > 0 || spec.operation.effort > 0;
  json bill = json::array();
  for (std::size_t i = 0; i < candidate.values.size(); ++i) {
    const SoughtValue& variable = candidate.option->values[i];
    const double value = candidate.values[i];
    json item{{"name", variable.name},
              {"part", variable.part == DesignPart::resistor    ? "resistor"
                       : variable.part == DesignPart::capacitor ? "capacitor"
                                                                : "setting"},
              {"count", 1},
              {"value", value},
              {"unit", variable.unit.symbol},
              {"written", format_quantity(value, variable.unit)}};
    if (variable.part != DesignPart::setting) {
      item["tolerance"] = spec.tolerances.at(variable.part);
      if (spec.series) item["series"] = name_of(*spec.series);
    }
    if (variable.part == DesignPart::resistor && operated)
      item["peak_power"] = extremes.resistor_power;
    if (variable.part == DesignPart::capacitor) {
      // The back-EMF has either sign.
      item["bipolar"] = spec.bipolar_capacitor;
      if (!spec.bipolar_capacitor) {
        item["count"] = 2;
        item["value"] = 2 * value;
        item["written"] = format_quantity(2 * value, variable.unit);
        item["arrangement"] = "back to back in series";
      }
      if (operated) item["peak_voltage"] = extremes.capacitor_voltage;
    }
    bill.push_back(std::move(item));
  }
  return bill;
}

json finite_or_nulls(const std::vector<double>& values) {
  json all = json::array();
  for (const double value : values) all.push_back(finite_or_null(value));
  return all;
}

json constraints_of(const DesignSpec& spec, const Candidate& candidate) {
  json kept = json::array();
  for (const DesignConstraint& constraint : spec.constraints) {
    kept.push_back({{"name", constraint.figure->name},
                    {"side", constraint.figure->is_minimum ? "min" : "max"},
                    {"unit", constraint.figure->unit.symbol},
                    {"limit", constraint.limit},
                    {"value", constraint.figure->value(candidate.figures)}});
  }
  return kept;
}

json describe_json(const DesignSpec& spec, const Design& design) {
  const DesignFigures& figures = design.candidate.figures;
  json entry = summarize(spec, design.candidate);
  entry["rated_stiffness"] = design.rated_stiffness;
  entry["worst_frequency_hz"] = figures.worst_frequency_hz;
  entry["damping_below_5_hz"] = figures.damping_below_5_hz;
  entry["yield"] = design.yield.value;
  entry["yield_low"] = design.yield.low;
  entry["yield_high"] = design.yield.high;
  if (mentions_pre_emphasis(spec)) entry["emphasis_gain"] = figures.emphasis_gain;
  entry["boundary"] = {{"damping", design.boundary.damping},
                       {"max_stiffness", finite_or_nulls(design.boundary.max_stiffness)}};
  entry["constraints"] = constraints_of(spec, design.candidate);
  entry["bill_of_materials"] = make_bill(spec, design.candidate, design.extremes);
  if (spec.operation.speed > 0 || spec.operation.effort > 0) {
    entry["amplifier_voltage"] = design.extremes.amplifier_voltage;
    entry["amplifier_current"] = design.extremes.amplifier_current;
  }
  entry["loses_because"] = design.reason.empty() ? json(nullptr) : json(design.reason);
  entry["model"] = design.model;
  return entry;
}

json binding_json(const std::optional<BindingConstraint>& binding) {
  if (!binding) return nullptr;
  json others = json::array();
  for (const MissedConstraint& other : binding->others)
    others.push_back({{"name", other.name},
                      {"limit", other.limit},
                      {"needed", other.needed},
                      {"unit", other.unit.symbol}});
  return {{"name", binding->name},        {"limit", binding->limit},
          {"needed", binding->needed},    {"enough_alone", binding->alone},
          {"unit", binding->unit.symbol}, {"topology", binding->topology},
          {"others", std::move(others)}};
}

const Unit& unit_of(const DesignSpec& spec, const std::string& name) {
  for (const DesignOption& option : spec.options)
    for (const SoughtValue& known : option.values)
      if (known.name == name) return known.unit;
  return dimension::none;
}

double number_or_infinite(const json& value) {
  return value.is_null() ? HUGE_VAL : value.get<double>();
}

// Four digits are enough for people; the result has them all.
std::string describe_number(double value, const Unit& unit) {
  if (!std::isfinite(value) || value == 0) return format_quantity(value, unit);
  const std::string rounded = fmt::format("{:.4g}", value);
  return format_quantity(std::strtod(rounded.c_str(), nullptr), unit);
}

std::string describe_values(const DesignSpec& spec, const json& values) {
  std::vector<std::string> texts;
  for (const auto& [name, value] : values.items()) {
    texts.push_back(value.is_boolean()
                        ? fmt::format("{} {}", name, value.get<bool>() ? "on" : "off")
                        : fmt::format("{} {}", name, format_quantity(value, unit_of(spec, name))));
  }
  return join(texts);
}

std::string describe_bill(const json& bill) {
  std::string text = "\nbill of materials\n";
  for (const json& item : bill) {
    const bool is_part = item["part"] != "setting";
    text += is_part
                ? fmt::format("  {} x {} {}", item["count"].get<int>(),
                              item["written"].get<std::string>(), item["part"].get<std::string>())
                : fmt::format("  {} set to {}", item["name"].get<std::string>(),
                              item["written"].get<std::string>());
    if (item.contains("tolerance"))
      text += fmt::format(" ± {:g} %", 100 * item["tolerance"].get<double>());
    if (item.contains("bipolar")) text += item["bipolar"].get<bool>() ? ", bipolar" : ", polarised";
    if (item.contains("arrangement")) text += ", " + item["arrangement"].get<std::string>();
    if (item.contains("peak_power"))
      text +=
          fmt::format(", {} at its peak", describe_number(item["peak_power"], dimension::power));
    if (item.contains("peak_voltage"))
      text += fmt::format(", {} at its peak",
                          describe_number(item["peak_voltage"], dimension::voltage));
    text += "\n";
  }
  return text;
}

std::string describe_constraints(const DesignSpec& spec, const json& constraints) {
  if (constraints.empty()) return "";
  std::string text = "\nconstraints\n";
  for (std::size_t i = 0; i < spec.constraints.size(); ++i) {
    const DesignConstraint& constraint = spec.constraints[i];
    const double value = constraints[i]["value"];
    const double limit = constraint.limit;
    const bool is_minimum = constraint.figure->is_minimum;
    const double left = is_minimum ? value / limit - 1 : 1 - value / limit;
    const Unit& unit = constraint.figure->unit;
    text += fmt::format("  {:<20} {:>16}, {} {}: {:.3g} % left\n", constraint.figure->name,
                        describe_number(value, unit), is_minimum ? "at least" : "at most",
                        describe_number(limit, unit), 100 * left);
  }
  return text;
}

// Topologies that were asked for and are not among the designs.
std::string describe_missing(const json& infeasible) {
  std::string text = infeasible.empty() ? "" : "\nwithout a design\n";
  for (const json& missing : infeasible)
    text += fmt::format("  {}: {}\n", missing["topology"].get<std::string>(),
                        missing["because"].get<std::string>());
  return text;
}

std::string describe_infeasible(const DesignSpec& spec, const json& binding) {
  if (binding.is_null())
    return spec.model.name +
           ": INFEASIBLE\nNo stiffness is passive at this virtual damping with any of the "
           "topologies.\n";
  const auto describe = [&](const json& missed, const std::string& topology) {
    const std::string name = missed["name"];
    Unit unit = dimension::none;
    for (const BoundedFigure& figure : list_bounded_figures(spec.model.device.motion))
      if (name == figure.name) unit = figure.unit;
    return fmt::format("{} of {}; it would have to give to {}{}", name,
                       format_quantity(missed["limit"], unit),
                       format_quantity(missed["needed"], unit), topology);
  };
  std::string text =
      fmt::format("{}: INFEASIBLE\nBinding: {}", spec.model.name,
                  describe(binding, fmt::format(" ({})", binding["topology"].get<std::string>())));
  for (const json& other : binding["others"]) text += ",\nand " + describe(other, "");
  const bool told = binding["enough_alone"].get<bool>() || !binding["others"].empty();
  return text + (told ? ".\n" : ", and others with it.\n");
}

}  // namespace

json make_design_result(const DesignSpec& spec, const DesignStudy& study) {
  json result = start_result("design", spec.model);
  result["spec"] = spec.source;
  result["feasible"] = !study.designs.empty();
  result["designs"] = json::array();
  for (const Design& design : study.designs)
    result["designs"].push_back(describe_json(spec, design));
  result["continuous"] = json::array();
  for (const Candidate& candidate : study.continuous)
    result["continuous"].push_back(summarize(spec, candidate));
  result["pareto"] = json::array();
  for (const Candidate& candidate : study.pareto)
    result["pareto"].push_back(summarize(spec, candidate));
  result["fronts"] = json::array();
  for (const auto& [topology, points] : study.fronts) {
    json front{{"topology", topology->name}, {"points", json::array()}};
    for (const Candidate& candidate : points) front["points"].push_back(summarize(spec, candidate));
    result["fronts"].push_back(std::move(front));
  }
  result["infeasible"] = json::array();
  for (const auto& [topology, because] : study.infeasible)
    result["infeasible"].push_back({{"topology", topology->name}, {"because", because}});
  result["virtual_damping"] = spec.damping;
  result["binding_constraint"] = binding_json(study.binding);
  return result;
}

std::string describe_design(const DesignSpec& spec, const json& result) {
  if (!result["feasible"].get<bool>())
    return describe_infeasible(spec, result["binding_constraint"]);
  const MotionUnits& units = units_of(spec.model.device.motion);
  const json& designs = result["designs"];
  std::string text =
      fmt::format("{}: {}, best first\n\n{:>3} {:>24} {:>14} {:>14} {:>18} {:>8}  {}\n",
                  spec.model.name, describe_count(designs.size(), "design"), "", "topology",
                  "largest K", "rated K", "apparent inertia", "yield", "values");
  int number = 1;
  for (const json& design : designs) {
    text +=
        fmt::format("{:>3} {:>24} {:>14} {:>14} {:>18} {:>6.4g} %  {}\n", number++,
                    design["topology"].get<std::string>(),
                    describe_number(number_or_infinite(design["max_stiffness"]), units.stiffness),
                    describe_number(design["rated_stiffness"], units.stiffness),
                    describe_number(design["apparent_inertia"], units.inertia),
                    100 * design["yield"].get<double>(), describe_values(spec, design["values"]));
  }
  if (designs.size() > 1) text += "\nwhy the others come after the first\n";
  for (std::size_t i = 1; i < designs.size(); ++i)
    text += fmt::format("  {}: {}\n", i + 1, designs[i]["loses_because"].get<std::string>());
  return text + describe_missing(result["infeasible"]) +
         describe_bill(designs[0]["bill_of_materials"]) +
         describe_constraints(spec, designs[0]["constraints"]);
}

}  // namespace gyrator
