#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/synthesis/design_spec.hpp"

namespace gyrator {
namespace {

using nlohmann::json;

std::vector<BoundedFigure> make_bounded_figures(Motion motion) {
  const MotionUnits& units = units_of(motion);
  return {
      {"max_stiffness", units.stiffness, true, false,
       [](const DesignFigures& f) { return f.max_stiffness; },
       "Largest passive stiffness, at least."},
      {"apparent_inertia", units.inertia, false, false,
       [](const DesignFigures& f) { return f.apparent_inertia; },
       "That the circuit adds to the rotor's below its corner (K_t² C of an rc), at most."},
      {"emphasis_gain", dimension::none, false, false,
       [](const DesignFigures& f) { return f.emphasis_gain; },
       "Largest gain of the pre-emphasis at any frequency, by which it raises noise and steps of "
       "the command; at most. Where pre-emphasis may be chosen and none is given: 10."},
      {"damping_below_5_hz", units.damping, false, false,
       [](const DesignFigures& f) { return f.damping_below_5_hz; },
       "Damping felt in slow motion, the device's own included, at most."},
      {"resistor_power", dimension::power, false, true,
       [](const DesignFigures& f) { return f.extremes.resistor_power; },
       "Peak in the resistor during `operation`, at most."},
      {"capacitor_voltage", dimension::voltage, false, true,
       [](const DesignFigures& f) { return f.extremes.capacitor_voltage; },
       "Peak across the capacitor during `operation`, at most."},
      {"amplifier_voltage", dimension::voltage, false, true,
       [](const DesignFigures& f) { return f.extremes.amplifier_voltage; },
       "Peak that the amplifier must give during `operation`, at most."},
      {"amplifier_current", dimension::current, false, true,
       [](const DesignFigures& f) { return f.extremes.amplifier_current; },
       "The same of its current."},
  };
}

ObjectSpec constraints_spec(Motion motion) {
  ObjectSpec spec{"constraints", "What a design must keep.", {}};
  for (const BoundedFigure& figure : list_bounded_figures(motion)) {
    const char* end = figure.is_minimum ? "min" : "max";
    spec.members.push_back(
        member::object(figure.name,
                       {"bound",
                        "A bound.",
                        {member::quantity(end, figure.unit).required().above(0).doc("The bound.")}})
            .doc(figure.meaning));
  }
  return spec;
}

ObjectSpec ranges_spec(Motion motion) {
  ObjectSpec spec{"ranges", "Where values are looked for.", {}};
  for (const Topology& topology : list_topologies(motion)) {
    for (const DesignVariable& variable : topology.variables) {
      spec.members.push_back(member::quantity(name_of(topology, variable), variable.unit)
                                 .above(0)
                                 .list(2, 2)
                                 .doc(variable.meaning + " Lowest and highest value."));
    }
  }
  return spec;
}

std::vector<std::string> topology_names() {
  std::vector<std::string> names;
  for (const Topology& topology : list_topologies(Motion::rotary)) names.push_back(topology.name);
  return names;
}

std::vector<std::string> series_names() {
  std::vector<std::string> names;
  for (const auto& series : preferred_series_names()) names.emplace_back(series.name);
  names.emplace_back("none");
  return names;
}

ObjectSpec objective_spec(const MotionUnits& units) {
  return {"objective",
          "What is best.",
          {member::choice("maximize", {"stiffness"}).doc("The stiffest passive wall."),
           member::choice("minimize", {"apparent_inertia"})
               .doc("The least inertia that carries a wall of `stiffness`."),
           member::quantity("stiffness", units.stiffness)
               .above(0)
               .doc("Of the wanted wall; with maximize: at least."),
           member::quantity("virtual_damping", units.damping)
               .doc("B of the wall; absent: the model's."),
           member::quantity("virtual_damping_to", units.damping)
               .doc("Other end of a range of B; the mean of the limit over it is what counts.")},
          {{"maximize", "minimize"}}};
}

ObjectSpec operation_spec(const MotionUnits& units) {
  return {"operation",
          "At which the extremes are taken: motion and wall at once, in the worst phase.",
          {member::quantity("speed", units.velocity).by_default(0).at_least(0).doc("Amplitude."),
           member::quantity("effort", units.effort)
               .by_default(0)
               .at_least(0)
               .doc("Amplitude of what the wall commands."),
           member::quantity("frequency", dimension::frequency)
               .by_default(10)
               .above(1e-3)
               .doc("Up to which both may alternate.")}};
}

ObjectSpec digital_spec() {
  return {"digital",
          "What the controller's program leaves to be chosen.",
          {member::quantity("velocity_cutoff", dimension::frequency)
               .above(0)
               .list(2, 2)
               .doc("Lowest and highest cut-off of the velocity's low-pass: of the model's "
                    "filtered_difference or butterworth, a filtered_difference where it has "
                    "neither. Absent: the model's estimator."),
           member::boolean("pre_emphasis")
               .doc("true: the command may pass the discrete inverse of the drive, where that is "
                    "better; false: never; absent: as in the model.")}};
}

ObjectSpec make_format(Motion motion) {
  const MotionTerms& terms = terms_of(motion);
  const auto tolerance = [](const char* name, double value) {
    return member::number(name).by_default(value).at_least(0).below(1);
  };
  return {
      terms.name,
      "What `gyrator design` is asked for.",
      {
          member::choice("schema", {design_schema_name}).required().doc("Version of the format."),
          member::text("model").required().doc("Model file of the device, relative to this one's."),
          member::object("objective", objective_spec(terms))
              .by_default({{"maximize", "stiffness"}})
              .doc("What is best."),
          member::choice("topologies", topology_names())
              .list(1)
              .by_default(topology_names())
              .doc("Dampings to choose from."),
          member::choice("series", series_names())
              .by_default("E24")
              .doc("Preferred values of the parts; none: any value."),
          member::object("ranges", ranges_spec(motion))
              .by_default(json::object())
              .doc("Where values are looked for."),
          member::object("digital", digital_spec())
              .by_default(json::object())
              .doc("Settings of the controller that may be chosen with the circuit."),
          member::object("constraints", constraints_spec(motion))
              .by_default(json::object())
              .doc("What a design must keep, at every temperature."),
          member::object("operation", operation_spec(terms))
              .by_default(json::object())
              .doc("For the constraints on power, voltage and current."),
          member::quantity("winding_rise", dimension::temperature)
              .list(2, 2)
              .doc("Coldest and warmest winding, above the reference temperature; the worst over "
                   "it counts. Absent: the model's."),
          member::boolean("bipolar_capacitor")
              .by_default(true)
              .doc("Whether bipolar capacitors can be had; false: two polarised ones back to back, "
                   "of twice the value each."),
          member::object("tolerance", {"tolerance",
                                       "Of the parts, for the yield.",
                                       {tolerance("resistance", 0.01).doc("± of resistors."),
                                        tolerance("capacitance", 0.2).doc("± of capacitors.")}})
              .by_default(json::object())
              .doc("Of the parts, for the yield; the model's own tolerances count too."),
          member::number("rated_share")
              .by_default(0.9)
              .above(0)
              .at_most(1)
              .doc("Of max_stiffness: what a stiffest design promises, in the model file and for "
                   "the yield."),
          member::integer("samples").by_default(1000).at_least(1).at_most(1e6).doc(
              "Devices drawn for the yield."),
          member::integer("designs").by_default(3).at_least(1).at_most(100).doc("To report."),
          member::integer("seed").by_default(1).at_least(0).doc("The same gives the same."),
      }};
}

}  // namespace

const std::vector<BoundedFigure>& list_bounded_figures(Motion motion) {
  static const std::vector<BoundedFigure> rotary = make_bounded_figures(Motion::rotary);
  static const std::vector<BoundedFigure> linear = make_bounded_figures(Motion::linear);
  return motion == Motion::rotary ? rotary : linear;
}

const Member& design_format() {
  static const Member format =
      member::variant("design", {make_format(Motion::rotary), make_format(Motion::linear)},
                      "motion")
          .kind_by_default("rotary")
          .doc("What `gyrator design` is asked for.");
  return format;
}

}  // namespace gyrator
