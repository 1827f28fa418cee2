#pragma once

#include "gyrator/core/error.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/document_spec.hpp"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace gyrator::documents_tests {

using nlohmann::json;

// A small device with one member of each sort, as the model file has them.
inline ObjectSpec make_device() {
  const ObjectSpec motor{
      "motor",
      "The winding.",
      {member::quantity("resistance", dimension::resistance)
           .required()
           .above(0, "a winding loses energy")
           .doc("Of the winding."),
       member::quantity("inductance", dimension::inductance)
           .by_default(0)
           .at_least(0)
           .doc("Self-inductance."),
       member::quantity("torque_constant", dimension::torque_constant).doc("Torque per ampere.")}};
  const ObjectSpec resistor{
      "resistor",
      "A resistor across the terminals.",
      {member::quantity("resistance", dimension::resistance).required().doc("Its value.")}};
  const ObjectSpec rc{"rc",
                      "A resistor and a capacitor in series.",
                      {member::quantity("resistance", dimension::resistance).required(),
                       member::quantity("capacitance", dimension::capacitance).required()}};
  const ObjectSpec cancellation{"cancellation",
                                "A negative resistance.",
                                {member::quantity("resistance", dimension::resistance),
                                 member::number("fraction").at_least(0).at_most(1)},
                                {{"resistance", "fraction"}}};
  const ObjectSpec current{
      "current",
      "A current amplifier.",
      {member::choice("sense", {"total", "motor"}).by_default("total").doc("Where it measures.")}};
  const ObjectSpec limit{"limits",
                         "",
                         {member::quantity("high", dimension::current), member::boolean("fold")},
                         {},
                         {{"high", "fold"}}};
  return {"device",
          "A device | with a motor.",
          {member::text("name").by_default("unnamed").doc("Free text."),
           member::object("motor", motor).required().doc("The motor."),
           member::variant("damping", {resistor, rc, cancellation})
               .list()
               .by_default(nlohmann::json::array()),
           member::variant("amplifier", {current, {"ideal", "No dynamics.", {}}})
               .by_default({{"kind", "ideal"}}),
           member::time("period").by_default("1 ms").above(0).doc("Of the loop."),
           member::integer("order").by_default(1).at_least(1).below(5),
           member::boolean("unilateral").by_default(false),
           member::quantity("frequencies", dimension::frequency).list(1, 3).above(0),
           member::quantity("quantum", dimension::angle_quantum).by_default(0),
           member::object("limits", limit), member::anything("notes")}};
}

inline json make_smallest() {
  return {{"motor", {{"resistance", 1.5}}}};
}

// The smallest document with one change in it.
inline json with(const char* pointer, const json& value) {
  json document = make_smallest();
  document[json::json_pointer(pointer)] = value;
  return document;
}

inline json read(const json& document) {
  return read_document(document, make_device(), "d.json");
}

struct Refusal {
  std::string place;
  std::string message;
};

inline Refusal find_refusal(const json& document) {
  try {
    read(document);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return {error.place(), error.message()};
  }
  return {"", "no error"};
}

// Two forms of a file, told apart by a key at the top, as the model's motion is.
inline Member make_two_forms() {
  const auto make_form = [](const char* motion, const Unit& unit) {
    return ObjectSpec{motion, "", {member::quantity("stiffness", unit).required()}};
  };
  return member::variant("",
                         {make_form("rotary", dimension::rotary_stiffness),
                          make_form("linear", dimension::linear_stiffness)},
                         "motion")
      .kind_by_default("rotary");
}

}  // namespace gyrator::documents_tests
