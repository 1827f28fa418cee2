#include "gyrator/studies/operator_format.hpp"

#include "gyrator/circuits/spice_subcircuit.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/rational.hpp"
#include "gyrator/documents/csv.hpp"

#include <filesystem>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

double time_of(const json& value) {
  return Rational::from_text(value.get<std::string>()).to_double();
}

std::string path_beside(const std::string& model_file, const json& name) {
  return (std::filesystem::path(model_file).parent_path() / name.get<std::string>()).string();
}

Member path_member() {
  return member::text("file").required().doc("Path, relative to the model file.");
}

ObjectSpec arm_spec() {
  return {"arm",
          "An arm, hand or finger with the values of straight motion that publications give, at a "
          "lever arm: each acts times radius^2.",
          {
              member::quantity("mass", dimension::mass)
                  .by_default(0)
                  .at_least(0)
                  .doc("That moves along."),
              member::quantity("damping", dimension::linear_damping)
                  .by_default(0)
                  .at_least(0)
                  .doc("To ground."),
              member::quantity("stiffness", dimension::linear_stiffness)
                  .by_default(0)
                  .at_least(0)
                  .doc("To ground."),
              member::quantity("radius", dimension::length)
                  .required()
                  .above(0)
                  .doc("From the axis to where the hand holds."),
          }};
}

ObjectSpec recorded_spec() {
  return {"recorded",
          "Samples from a CSV file, linear in between, in SI units; its first row is at the start.",
          {
              path_member(),
              member::text("time").by_default("time_s").doc("Column of the times, in seconds."),
              member::text("column").required().doc("Column of the values."),
              member::choice("quantity", {"force", "motion"})
                  .required()
                  .doc("An effort at the port, or the position that the hand intends, which acts "
                       "through the operator's spring and damper."),
          }};
}

HandGesture through(Gesture gesture, const Operator& held_by) {
  HandGesture hand{std::move(gesture)};
  if (const auto* arm = std::get_if<MassSpringDamper>(&held_by)) {
    hand.stiffness = arm->stiffness;
    hand.damping = arm->damping;
  }
  return hand;
}

HitGesture parse_hit(const json& g, const std::string& file) {
  HitGesture hit{.effort = g["effort"], .width = time_of(g["width"]), .times = {}};
  for (const json& time : g["times"]) hit.times.push_back(time_of(time));
  if (g["shape"] == "raised_cosine") hit.shape = HitGesture::Shape::raised_cosine;
  if (g["repeat"].is_null()) return hit;
  hit.repeat = time_of(g["repeat"]);
  if (*hit.repeat < hit.width) {
    throw Error(
        ErrorCode::bad_input, file + ": /simulation/gesture/repeat",
        fmt::format("{:g} s: must be at least the pulse's width, {:g} s", *hit.repeat, hit.width));
  }
  return hit;
}

StrokeGesture parse_stroke(const json& g) {
  const bool motion = g["effort"].is_null();
  return {g[motion ? "motion" : "effort"], g["frequency"], motion};
}

RecordedGesture read_recording(const json& g, const std::string& model_file) {
  const std::string path = path_beside(model_file, g["file"]);
  const std::string time = g["time"];
  try {
    CsvColumns data = read_csv(path, {time, g["column"].get<std::string>()});
    RecordedGesture recorded{data.columns[0], data.columns[1], g["quantity"] == "motion", {}};
    const auto place = [&](std::size_t row) {
      return fmt::format("{}:{}: column \"{}\"", path, data.lines[row], time);
    };
    for (std::size_t i = 1; i < recorded.time.size(); ++i) {
      if (recorded.time[i] > recorded.time[i - 1]) continue;
      throw Error(ErrorCode::bad_input, place(i),
                  fmt::format("{:g} s after {:g} s: times must increase", recorded.time[i],
                              recorded.time[i - 1]));
    }
    recorded.end_place = place(data.lines.size() - 1);
    return recorded;
  } catch (const Error& error) {  // the reader knows the recording, not who asked for it
    throw Error(error.code(), error.place(),
                fmt::format("{} (gesture of {})", error.message(), model_file));
  }
}

NetworkOperator read_network(const json& o, const std::string& model_file) {
  const std::string path = path_beside(model_file, o["file"]);
  try {
    NetworkOperator network{read_subcircuit(path, o["subckt"].get<std::string>(), {})};
    check_passive_operator(network);
    return network;
  } catch (const Error& error) {  // the reader knows the netlist, not who asked for it
    throw Error(error.code(), error.place(),
                fmt::format("{} (operator of {})", error.message(), model_file));
  }
}

}  // namespace

std::vector<ObjectSpec> operator_specs(const MotionUnits& units, const char* inertia_name) {
  std::vector<ObjectSpec> specs{
      {"free", "Nothing holds the port.", {}},
      {"clamped", "The port does not move.", {}},
      {"mass_spring_damper",
       "A hand as inertia, damper and spring to ground; the spring is at rest at position zero.",
       {
           member::quantity(inertia_name, units.inertia)
               .by_default(0)
               .at_least(0)
               .doc("Of the hand."),
           member::quantity("damping", units.damping).by_default(0).at_least(0).doc("To ground."),
           member::quantity("stiffness", units.stiffness)
               .by_default(0)
               .at_least(0)
               .doc("To ground."),
       }}};
  const bool rotary = units.position == dimension::angle;
  if (rotary) specs.push_back(arm_spec());
  specs.push_back({"network",
                   "Any passive hand as a circuit with two terminals from a SPICE file: its first "
                   "pin is the port, its second ground; a capacitor is an inertia, an inductor a "
                   "spring of 1/L, a resistor a damper of 1/R, in SI units of the motion.",
                   {
                       path_member(),
                       member::text("subckt").by_default("").doc(
                           "Name of the subcircuit; absent: the file's only one."),
                   }});
  return specs;
}

std::vector<ObjectSpec> gesture_specs(const MotionUnits& units) {
  const auto effort = [&](const char* what) {
    return member::quantity("effort", units.effort).required().doc(what);
  };
  return {
      {"hit",
       "Pulses of force.",
       {
           effort("At the top of a pulse."),
           member::time("width").required().above(0).doc("Of a pulse, from zero to zero."),
           member::time("times").list(1).by_default({0}).at_least(0).doc("When the pulses start."),
           member::time("repeat").above(0).doc(
               "All of them come again every so long; absent: once."),
           member::choice("shape", {"half_sine", "raised_cosine"})
               .by_default("half_sine")
               .doc("Of a pulse."),
       }},
      {"hold",
       "A force that rises linearly and stays.",
       {
           effort("In the end."),
           member::time("start").by_default(0).at_least(0).doc("When it begins to rise."),
           member::time("rise").by_default(0).at_least(0).doc("How long it takes."),
       }},
      {"stroke",
       "A sine of force or intended motion, from zero upwards.",
       {
           member::quantity("effort", units.effort).doc("Amplitude of a force at the port."),
           member::quantity("motion", units.position)
               .doc("Amplitude of the hand's intended position, which acts through the "
                    "operator's spring and damper."),
           member::quantity("frequency", dimension::frequency)
               .required()
               .above(0)
               .doc("Of the sine."),
       },
       {{"effort", "motion"}}},
      {"random",
       "A force of even power up to a frequency, from simulation.seed.",
       {
           effort("Root mean square.").at_least(0),
           member::quantity("bandwidth", dimension::frequency)
               .required()
               .above(0)
               .doc("Highest frequency in it."),
       }},
      recorded_spec()};
}

Operator parse_operator(const json& o, const std::string& file) {
  if (o["kind"] == "clamped") return ClampedOperator{};
  if (o["kind"] == "free") return FreeOperator{};
  if (o["kind"] == "network") return read_network(o, file);
  if (o["kind"] == "arm") {
    const double r = o["radius"];
    return MassSpringDamper{r * r * o["mass"].get<double>(),
                            r * r * o["damping"].get<double>(),
                            r * r * o["stiffness"].get<double>(),
                            {}};
  }
  return MassSpringDamper{
      o.contains("inertia") ? o["inertia"] : o["mass"], o["damping"], o["stiffness"], {}};
}

std::optional<HandGesture> parse_gesture(const json& g, const Operator& held_by,
                                         const std::string& file) {
  if (g.is_null()) return std::nullopt;
  if (std::holds_alternative<ClampedOperator>(held_by)) {
    throw Error(ErrorCode::bad_input, file + ": /simulation/gesture",
                "with an operator of kind \"clamped\": its port does not move, whatever the hand "
                "does; use \"free\" or one with dynamics");
  }
  HandGesture hand;
  if (g["kind"] == "hit") {
    hand = through(parse_hit(g, file), held_by);
  } else if (g["kind"] == "hold") {
    hand = through(HoldGesture{g["effort"], time_of(g["start"]), time_of(g["rise"])}, held_by);
  } else if (g["kind"] == "stroke") {
    hand = through(parse_stroke(g), held_by);
  } else if (g["kind"] == "random") {
    hand = through(RandomGesture{g["effort"], g["bandwidth"]}, held_by);
  } else {
    hand = through(read_recording(g, file), held_by);
  }
  if (is_motion(hand.gesture) && hand.stiffness == 0 && hand.damping == 0) {
    throw Error(ErrorCode::bad_input, file + ": /simulation/gesture",
                "a motion acts through the hand's spring and damper: the operator must have a "
                "stiffness or a damping (kinds mass_spring_damper and arm)");
  }
  return hand;
}

}  // namespace gyrator
