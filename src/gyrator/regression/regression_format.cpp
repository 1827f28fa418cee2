#include "gyrator/regression/regression_study.hpp"

namespace gyrator {
namespace {

std::vector<Member> tolerance_members() {
  return {member::anything("absolute")
              .by_default(0)
              .doc("In the figure's unit: a number in SI units, or with its unit: \"1 uN.m\"."),
          member::number("relative").by_default(0).at_least(0).doc("Share of the reference.")};
}

ObjectSpec tolerance_spec() {
  ObjectSpec spec{"tolerance", "Allowed: absolute + relative × |baseline|.", tolerance_members()};
  spec.members.push_back(
      member::choice("side", {"both", "below", "above"})
          .by_default("both")
          .doc("below: only a smaller value is a regression; above: only a larger one."));
  return spec;
}

ObjectSpec published_spec() {
  ObjectSpec spec{"published", "A value that a paper states, compared beside the baseline.", {}};
  spec.members = {
      member::anything("value").required().doc(
          "A number in the figure's SI unit; a list of them for a varied run."),
      member::text("source").required().doc("Author, year, equation."),
  };
  for (Member& member : tolerance_members()) spec.members.push_back(std::move(member));
  return spec;
}

ObjectSpec expectation_spec() {
  return {"expectation",
          "A figure of the answer and what it is to be. Without `equals`, `none` and bounds it is "
          "compared with the baseline.",
          {
              member::text("figure").required().doc(
                  "Path in the command's JSON answer: members by '.', items of lists by "
                  "`[number]`, `[member=value]` or, all of them, `[*]`; then `#` is a list's "
                  "length, `#min`, `#max`, `#first` and `#last` one of its numbers. In a run that "
                  "varies, the figure is the list of its values."),
              member::text("name").doc("What tables and baseline call it. Absent: its path."),
              member::text("unit").doc("Its SI unit, for tables and the baseline."),
              member::anything("equals").doc(
                  "Text, boolean, number or list that it is to be exactly; no baseline then."),
              member::boolean("none").by_default(false).doc("It is to be null: nothing bounds it."),
              member::number("at_least").doc("Smallest allowed value; no baseline then."),
              member::number("at_most").doc("Largest allowed value; no baseline then."),
              member::object("tolerance", tolerance_spec())
                  .doc("Against the baseline. Absent: the study's."),
              member::object("published", published_spec()).doc("Compared as well."),
          },
          {},
          {{"equals", "none", "at_least"}, {"equals", "none", "at_most"}}};
}

ObjectSpec trace_spec() {
  return {"trace",
          "The motion must stay in a tube around the reference: within what any reference point "
          "less than `time` away allows, ± each column's tolerance.",
          {
              member::anything("columns").required().doc(
                  "Column of the trace → {\"absolute\": \"1e-6 rad\", \"relative\": 0.001}, the "
                  "latter of what the reference spans."),
              member::quantity("time", dimension::time)
                  .by_default(0)
                  .at_least(0)
                  .doc("How far in time the trace may be shifted."),
          }};
}

ObjectSpec run_spec() {
  return {
      "run",
      "A command of this program on a model.",
      {
          member::text("name").required().doc("Letters, digits, '_' and '-'."),
          member::choice("command", {"passivity", "zwidth", "impedance", "simulate", "twoport",
                                     "stability-map", "compare", "environment", "workspace",
                                     "tolerance", "design", "spice", "verify-certificate"})
              .required()
              .doc("What computes."),
          member::text("model").required().doc(
              "Model file (or spec, profile, certificate), relative to the study's."),
          member::anything("set").doc(
              "Path → value that stands there instead: {\"controller.stiffness\": \"8 N/m\"}. "
              "An object or list replaces the whole."),
          member::anything("vary").doc(
              "Path → list of values: the run once for each, several paths in lockstep."),
          member::text("arguments")
              .list()
              .by_default(nlohmann::json::array())
              .doc("Further options of the command; --json, -o and --csv are the study's."),
          member::anything("exit_code")
              .by_default(0)
              .doc("How the program is to end; 1 where the answer is to be no. A list in a run "
                   "that varies."),
          member::integer("seed").at_least(0).doc("Of the random numbers. Absent: the model's."),
          member::object("expect", expectation_spec())
              .list()
              .by_default(nlohmann::json::array())
              .doc("What is compared."),
          member::object("trace", trace_spec()).doc("Of `simulate`: the motion."),
          member::object("energy",
                         {"energy",
                          "The ledger must close.",
                          {member::number("residual")
                               .required()
                               .above(0)
                               .doc("Largest |residual|, as share of the largest energy in it.")}})
              .doc("Of `simulate`."),
      }};
}

ObjectSpec axis_spec() {
  return {"axis",
          "One of the axes.",
          {member::text("label").required().doc("Quantity."),
           member::text("unit").by_default("").doc("After scaling."),
           member::boolean("logarithmic").by_default(false).doc("Scale."),
           member::number("min").doc("Absent: from the data."),
           member::number("max").doc("Absent: from the data.")}};
}

ObjectSpec figure_spec() {
  const auto scale = [](const char* name) {
    return member::number(name).by_default(1).doc("Factor to the axis' unit.");
  };
  return {"figure",
          "A picture that `study run` draws.",
          {
              member::text("name").required().doc("Of its file, without .svg."),
              member::text("title").by_default("").doc("Over it."),
              member::text("caption").by_default("").doc("Under it, in the report."),
              member::object("x", axis_spec()).required().doc("Horizontal axis."),
              member::object("y", axis_spec()).required().doc("Vertical axis."),
              member::object(
                  "curves",
                  {"curve",
                   "What a run gives.",
                   {member::text("run").required().doc("Its name."),
                    member::text("x").required().doc(
                        "Path in the answer, or `set.PATH`: the varied value."),
                    member::text("y").required().doc(
                        "Path in the answer; of a list in a run that varies, one curve each."),
                    member::text("title").by_default("").doc("In the key."),
                    member::choice("style", {"line", "dashed", "dotted", "steps", "points"})
                        .by_default("line")
                        .doc("How it is drawn."),
                    scale("x_scale"), scale("y_scale")}})
                  .list(1)
                  .required()
                  .doc("Drawn in this order."),
              member::object("published",
                             {"points",
                              "What a paper shows, as points.",
                              {member::text("title").required().doc("In the key."),
                               member::text("source").by_default("").doc("Author and year."),
                               member::number("x").list(1).required().doc("In the axis' unit."),
                               member::number("y").list(1).required().doc("In the axis' unit.")}})
                  .list()
                  .by_default(nlohmann::json::array())
                  .doc("Drawn as points."),
          }};
}

}  // namespace

const Member& regression_format() {
  static const Member format = member::object(
      "study",
      {"study",
       "Models, commands on them, and figures that must not change.",
       {
           member::choice("schema", {regression_schema_name})
               .required()
               .doc("Version of the format."),
           member::text("name").required().doc("Of the study."),
           member::text("about").by_default("").doc("What it shows, and whose result it is."),
           member::object("tolerance", tolerance_spec())
               .by_default({{"relative", 1e-6}})
               .doc("Of figures that have none of their own."),
           member::object("runs", run_spec()).list(1).required().doc("What is computed."),
           member::object("figures", figure_spec())
               .list()
               .by_default(nlohmann::json::array())
               .doc("What is drawn."),
       }});
  return format;
}

}  // namespace gyrator
