#include "gyrator/core/error.hpp"
#include "gyrator/core/rational.hpp"
#include "gyrator/documents/document_manual.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/document_schema.hpp"
#include "gyrator/documents/document_spec.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace gyrator {
namespace {

using nlohmann::json;

// A small device with one member of each sort, as the model file has them.
ObjectSpec make_device() {
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
  return {
      "device",
      "A device | with a motor.",
      {member::text("name").by_default("unnamed").doc("Free text."),
       member::object("motor", motor).required().doc("The motor."),
       member::variant("damping", {resistor, rc, cancellation}).list().by_default(json::array()),
       member::variant("amplifier", {current, {"ideal", "No dynamics.", {}}})
           .by_default({{"kind", "ideal"}}),
       member::time("period").by_default("1 ms").above(0).doc("Of the loop."),
       member::integer("order").by_default(1).at_least(1).below(5),
       member::boolean("unilateral").by_default(false),
       member::quantity("frequencies", dimension::frequency).list(1, 3).above(0),
       member::quantity("quantum", dimension::angle_quantum).by_default(0),
       member::object("limits", limit), member::anything("notes")}};
}

json make_smallest() {
  return {{"motor", {{"resistance", 1.5}}}};
}

// The smallest document with one change in it.
json with(const char* pointer, const json& value) {
  json document = make_smallest();
  document[json::json_pointer(pointer)] = value;
  return document;
}

json read(const json& document) {
  return read_document(document, make_device(), "d.json");
}

struct Refusal {
  std::string place;
  std::string message;
};

Refusal find_refusal(const json& document) {
  try {
    read(document);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return {error.place(), error.message()};
  }
  return {"", "no error"};
}

TEST(ReadDocument, fills_defaults_and_writes_null_for_what_is_optional) {
  EXPECT_EQ(read(make_smallest()), json::parse(R"({
    "name": "unnamed",
    "motor": {"resistance": 1.5, "inductance": 0.0, "torque_constant": null},
    "damping": [], "amplifier": {"kind": "ideal"}, "period": "1/1000", "order": 1,
    "unilateral": false, "frequencies": null, "quantum": 0.0, "limits": null, "notes": null
  })"));
}

TEST(ReadDocument, turns_quantities_into_si_numbers_and_times_into_fractions) {
  const json document = read(json::parse(R"({
    "motor": {"resistance": "4.7 kohm", "inductance": "0.5 mH", "torque_constant": "3 V.s/rad"},
    "damping": [{"kind": "rc", "resistance": 5, "capacitance": "2200 uF"}],
    "period": "1/60 s", "frequencies": ["1 kHz", 2], "quantum": "8192 counts/rev", "order": 3.0
  })"));
  EXPECT_EQ(document["motor"]["resistance"], 4700.0);
  EXPECT_EQ(document["motor"]["inductance"], 0.5e-3);
  EXPECT_EQ(document["damping"][0]["capacitance"], 2200e-6);
  EXPECT_EQ(document["damping"][0]["kind"], "rc");
  EXPECT_EQ(document["frequencies"], json({1000.0, 2.0}));
  EXPECT_EQ(document["period"], "1/60");
  EXPECT_EQ(Rational::from_text(document["period"].get<std::string>()), Rational(1, 60));
  EXPECT_DOUBLE_EQ(document["quantum"].get<double>(), 2 * M_PI / 8192);
  EXPECT_TRUE(document["order"].is_number_integer());
  EXPECT_TRUE(document["motor"]["resistance"].is_number_float());
}

TEST(ReadDocument, time_is_exact_from_a_number_too) {
  EXPECT_EQ(read(with("/period", 0.1))["period"], "1/10");
  EXPECT_EQ(read(with("/period", 2))["period"], "2/1");
}

TEST(ReadDocument, reading_the_normal_form_again_changes_nothing) {
  json document = make_smallest();
  document["$schema"] = "https://example.org/device.json";
  document["damping"] = {{{"kind", "cancellation"}, {"fraction", "50 %"}}};
  document["limits"] = {{"high", "2 A"}};
  document["notes"] = {{"free", {1, "two"}}};
  const json once = read(document);
  EXPECT_FALSE(once.contains("$schema"));
  EXPECT_EQ(once["damping"][0]["fraction"], 0.5);
  EXPECT_EQ(read(once), once);
}

TEST(ReadDocument, unknown_key_gives_nearest_and_all_allowed) {
  const auto refusal = find_refusal(with("/motor/resistence", 5));
  EXPECT_EQ(refusal.place, "d.json: /motor/resistence");
  EXPECT_EQ(refusal.message,
            "unknown key 'resistence': allowed: resistance, inductance, torque_constant; did "
            "you mean 'resistance'?");
  EXPECT_EQ(find_refusal(with("/$schema", "x")).message, "no error");
  EXPECT_NE(find_refusal(with("/motor/$schema", "x")).message, "no error");
}

TEST(ReadDocument, key_of_another_kind_is_named_as_such) {
  const auto refusal = find_refusal(
      with("/damping", {{{"kind", "resistor"}, {"resistance", 1}, {"capacitance", 1}}}));
  EXPECT_EQ(refusal.place, "d.json: /damping/0/capacitance");
  EXPECT_EQ(refusal.message,
            "unknown key 'capacitance' for 'resistor' (it belongs to 'rc'): allowed: kind, "
            "resistance");
}

TEST(ReadDocument, missing_key_tells_what_is_expected_and_what_is_there) {
  const auto refusal = find_refusal({{"motor", {{"inductance", 1e-3}}}});
  EXPECT_EQ(refusal.place, "d.json: /motor");
  EXPECT_EQ(refusal.message,
            "the key 'resistance' is missing: a resistance [ohm], such as \"1.5 ohm\" is expected; "
            "keys given: inductance");
  EXPECT_EQ(find_refusal(json::object()).place, "d.json: /");
}

TEST(ReadDocument, wrong_type_tells_what_was_found) {
  const std::vector<std::tuple<const char*, json, std::string>> cases{
      {"/motor", 5,
       "found the number 5: an object {resistance, inductance, torque_constant} is expected"},
      {"/motor/resistance", true,
       "found true: a resistance [ohm], such as \"1.5 ohm\" is expected"},
      {"/motor/resistance", nullptr,
       "found null: a resistance [ohm], such as \"1.5 ohm\" is expected"},
      {"/motor/resistance", json::array({1, 2}),
       "found a list of 2: a resistance [ohm], such as \"1.5 ohm\" is expected"},
      {"/name", 5, "found the number 5: a text is expected"},
      {"/unilateral", "true", "found the text \"true\": true or false is expected"},
      {"/order", "1", "found the text \"1\": a whole number is expected"},
      {"/order", 1.5, "found the number 1.5: a whole number is expected"},
      {"/period", json::object(), "found an object {}: a time [s], such as \"1 ms\" is expected"},
      {"/damping", json::object(),
       "found an object {}: a list, each item an object with \"kind\" one of resistor, rc, "
       "cancellation, "
       "is expected"},
      {"/amplifier", "ideal",
       "found the text \"ideal\": an object with \"kind\" one of current, ideal is expected; write "
       "{\"kind\": \"ideal\"}"},
      {"/amplifier", "idle",
       "found the text \"idle\": an object with \"kind\" one of current, ideal is expected"},
      {"/frequencies", 5,
       "found the number 5: a list of at least 1 and at most 3, each item a frequency [Hz], such "
       "as "
       "\"1 kHz\", is expected"},
  };
  for (const auto& [pointer, value, message] : cases) {
    const auto refusal = find_refusal(with(pointer, value));
    EXPECT_EQ(refusal.message, message);
    EXPECT_EQ(refusal.place, std::string("d.json: ") + pointer);
  }
}

TEST(ReadDocument, item_of_a_list_is_not_asked_to_be_a_list) {
  EXPECT_EQ(
      find_refusal(with("/damping", {3})).message,
      "found the number 3: an object with \"kind\" one of resistor, rc, cancellation is expected");
}

TEST(ReadDocument, long_list_of_keys_is_cut_between_two) {
  json motor;
  for (const char c : {'a', 'b', 'c', 'd', 'e', 'f', 'g'})
    motor["key_of_many_" + std::string(1, c)] = 1;
  const auto message = find_refusal(with("/name", motor)).message;
  EXPECT_NE(message.find("key_of_many_c, key_of_many_d, …"), std::string::npos) << message;
}

TEST(ReadDocument, document_that_is_no_object_is_refused) {
  for (const json& document : {json(), json(5), json::array()}) {
    EXPECT_EQ(find_refusal(document).place, "d.json: /");
  }
}

TEST(ReadDocument, wrong_dimension_is_refused_at_its_place) {
  const auto refusal = find_refusal(with("/motor/resistance", "5 uF"));
  EXPECT_EQ(refusal.place, "d.json: /motor/resistance");
  EXPECT_EQ(refusal.message,
            "'5 uF': this is a capacitance [F]: a resistance [ohm] is expected, such as "
            "\"1.5 ohm\"");
  EXPECT_EQ(find_refusal(with("/period", "1 kHz")).place, "d.json: /period");
}

TEST(ReadDocument, bounds_hold_on_both_sides_of_each_limit) {
  EXPECT_EQ(find_refusal(with("/motor/resistance", 5e-324)).message, "no error");
  EXPECT_EQ(find_refusal(with("/motor/resistance", 0)).message,
            "0 ohm: must be above 0 ohm, for a winding loses energy");
  EXPECT_EQ(find_refusal(with("/motor/resistance", "-1500 mohm")).message,
            "\"-1500 mohm\" is -1.5 ohm: must be above 0 ohm, for a winding loses energy");
  EXPECT_EQ(find_refusal(with("/motor/inductance", 0)).message, "no error");
  EXPECT_EQ(find_refusal(with("/motor/inductance", -1e-9)).message,
            "-1e-09 H: must be at least 0 H");
  EXPECT_EQ(find_refusal(with("/order", 4)).message, "no error");
  EXPECT_EQ(find_refusal(with("/order", 5)).message, "5: must be at least 1 and below 5");
  EXPECT_EQ(find_refusal(with("/order", 0)).message, "0: must be at least 1 and below 5");
  EXPECT_EQ(find_refusal(with("/period", 0)).message, "0 s: must be above 0 s");
  EXPECT_EQ(find_refusal(with("/frequencies", {1, 2, "0 Hz"})).place, "d.json: /frequencies/2");
  const auto fraction = [](const json& value) {
    return find_refusal(with("/damping", {{{"kind", "cancellation"}, {"fraction", value}}}))
        .message;
  };
  EXPECT_EQ(fraction(1), "no error");
  EXPECT_EQ(fraction(1.0000001), "1.0000001: must be at least 0 and at most 1");
}

TEST(ReadDocument, list_has_its_number_of_items) {
  EXPECT_EQ(find_refusal(with("/frequencies", {1})).message, "no error");
  EXPECT_EQ(find_refusal(with("/frequencies", {1, 2, 3})).message, "no error");
  EXPECT_NE(find_refusal(with("/frequencies", json::array())).message, "no error");
  EXPECT_NE(find_refusal(with("/frequencies", {1, 2, 3, 4})).message, "no error");
}

TEST(ReadDocument, unknown_kind_and_choice_give_nearest_and_all_allowed) {
  const auto kind = find_refusal(with("/damping", {{{"kind", "resitor"}}}));
  EXPECT_EQ(kind.place, "d.json: /damping/0/kind");
  EXPECT_EQ(
      kind.message,
      "unknown kind 'resitor': allowed: resistor, rc, cancellation; did you mean 'resistor'?");
  const auto choice = find_refusal(with("/amplifier", {{"kind", "current"}, {"sense", "motors"}}));
  EXPECT_EQ(choice.place, "d.json: /amplifier/sense");
  EXPECT_EQ(choice.message, "unknown name 'motors': allowed: total, motor; did you mean 'motor'?");
  EXPECT_EQ(find_refusal(with("/damping", {{{"kind", 5}}})).place, "d.json: /damping/0/kind");
  EXPECT_EQ(find_refusal(with("/damping", json::array({json::object()}))).message,
            "the key 'kind' is missing: one of resistor, rc, cancellation is expected");
}

TEST(ReadDocument, members_that_exclude_one_another_are_counted) {
  const auto refusal = [](json object) {
    object["kind"] = "cancellation";
    return find_refusal(with("/damping", json::array({object}))).message;
  };
  EXPECT_EQ(refusal({{"fraction", 0.5}}), "no error");
  EXPECT_EQ(refusal({{"fraction", 0.5}, {"resistance", nullptr}}), "no error");
  EXPECT_EQ(refusal({{"fraction", 0.5}, {"resistance", 1}}),
            "resistance and fraction are given: exactly one must be given of resistance, fraction");
  EXPECT_EQ(refusal(json::object()),
            "none is given: exactly one must be given of resistance, fraction");
  EXPECT_EQ(find_refusal(with("/limits", json::object())).message, "no error");
  EXPECT_EQ(find_refusal(with("/limits", {{"high", 1}})).message, "no error");
  EXPECT_EQ(find_refusal(with("/limits", {{"high", 1}, {"fold", true}})).message,
            "high and fold are given: at most one may be given of high, fold");
}

TEST(ReadDocument, refuses_what_is_not_finite) {
  EXPECT_EQ(find_refusal(with("/motor/resistance", std::nan(""))).message,
            "nan: not a finite number, which a quantity must be");
  EXPECT_NE(find_refusal(with("/motor/resistance", "nan")).message.find("not a finite"),
            std::string::npos);
  EXPECT_EQ(find_refusal(with("/period", std::numeric_limits<double>::infinity())).place,
            "d.json: /period");
  EXPECT_NE(find_refusal(with("/order", std::nan(""))).message, "no error");
  EXPECT_NE(find_refusal(with("/order", UINT64_MAX)).message, "no error");
  EXPECT_NE(find_refusal(with("/period", UINT64_MAX)).message, "no error");
}

TEST(ReadDocument, pointer_escapes_and_long_texts_are_cut) {
  EXPECT_EQ(find_refusal(with("/motor/a~1b~0c", 1)).place, "d.json: /motor/a~1b~0c");
  const std::string message = find_refusal(with("/unilateral", std::string(100000, 'x'))).message;
  EXPECT_LT(message.size(), 200U);
}

TEST(ReadDocument, default_that_breaks_its_own_rule_is_refused) {
  const ObjectSpec spec{
      "", "", {member::quantity("r", dimension::resistance).above(0).by_default("0 ohm")}};
  EXPECT_THROW(read_document(json::object(), spec, ""), Error);
}

// Two forms of a file, told apart by a key at the top, as the model's motion is.
Member make_two_forms() {
  const auto make_form = [](const char* motion, const Unit& unit) {
    return ObjectSpec{motion, "", {member::quantity("stiffness", unit).required()}};
  };
  return member::variant("",
                         {make_form("rotary", dimension::rotary_stiffness),
                          make_form("linear", dimension::linear_stiffness)},
                         "motion")
      .kind_by_default("rotary");
}

TEST(ReadDocument, root_may_be_a_variant_with_a_default_kind) {
  const Member root = make_two_forms();
  EXPECT_EQ(read_document({{"stiffness", "3 N.m"}}, root, ""),
            json({{"motion", "rotary"}, {"stiffness", 3.0}}));
  EXPECT_EQ(
      read_document({{"motion", "linear"}, {"stiffness", "3 N/m"}, {"$schema", ""}}, root, ""),
      json({{"motion", "linear"}, {"stiffness", 3.0}}));
  EXPECT_THROW(read_document({{"stiffness", "3 N/m"}}, root, ""), Error);
  try {
    read_document({{"motion", "linera"}, {"stiffness", "3 N/m"}}, root, "");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.place(), "/motion");
    EXPECT_EQ(error.message(),
              "unknown motion 'linera': allowed: rotary, linear; did you mean 'linear'?");
  }
}

TEST(WriteJsonSchema, has_each_member_with_its_type_bounds_and_default) {
  const json schema = build_json_schema(member::object("", make_device()), "gyrator/device/1");
  EXPECT_EQ(schema["$id"], "gyrator/device/1");
  EXPECT_EQ(schema["additionalProperties"], false);
  EXPECT_EQ(schema["required"], json({"motor"}));
  const json& motor = schema["properties"]["motor"];
  EXPECT_EQ(motor["type"], "object");
  const json& resistance = motor["properties"]["resistance"];
  EXPECT_EQ(resistance["anyOf"][0], json({{"type", "number"}, {"exclusiveMinimum", 0.0}}));
  EXPECT_EQ(resistance["anyOf"][1]["type"], "string");
  EXPECT_EQ(resistance["description"],
            "Of the winding. In ohm, or a text such as \"1.5 ohm\". Must be above 0 ohm.");
  EXPECT_EQ(motor["properties"]["inductance"]["default"], 0);
  EXPECT_EQ(motor["properties"]["torque_constant"]["anyOf"].size(), 3U);  // null too
  EXPECT_EQ(schema["properties"]["order"]["exclusiveMaximum"], 5.0);
  EXPECT_EQ(schema["properties"]["frequencies"]["minItems"], 1);
  // Its rule on keys must not be asked of null.
  EXPECT_EQ(schema["properties"]["limits"]["anyOf"][0]["allOf"].size(), 1U);
  EXPECT_EQ(schema["properties"]["limits"]["anyOf"][1], json({{"type", "null"}}));
}

TEST(WriteJsonSchema, variant_is_one_of_objects_with_a_constant_kind) {
  const json schema = build_json_schema(member::object("", make_device()), "x");
  const json& kinds = schema["properties"]["damping"]["items"]["oneOf"];
  ASSERT_EQ(kinds.size(), 3U);
  EXPECT_EQ(kinds[1]["properties"]["kind"]["const"], "rc");
  EXPECT_EQ(kinds[1]["required"], json({"kind", "resistance", "capacitance"}));
  EXPECT_EQ(kinds[2]["allOf"][0]["oneOf"].size(), 2U);
  const json& sense = schema["properties"]["amplifier"]["oneOf"][0]["properties"]["sense"];
  EXPECT_EQ(sense["enum"], json({"total", "motor"}));
}

TEST(WriteJsonSchema, default_kind_need_not_be_written) {
  const json schema = build_json_schema(make_two_forms(), "x");
  EXPECT_EQ(schema["oneOf"][0]["required"], json({"stiffness"}));
  EXPECT_EQ(schema["oneOf"][1]["required"], json({"motion", "stiffness"}));
}

TEST(WriteManualTable, has_a_row_for_each_key) {
  const std::string manual = write_manual_table(make_device());
  for (const char* part : {
           "### The file\n\nA device | with a motor.\n",
           "| key | unit | default | allowed | meaning |",
           "| `period` | s | `\"1 ms\"` | above 0 s | Of the loop. |",
           "### `motor`\n\nThe winding.",
           "| `resistance` | ohm | required | above 0 ohm | Of the winding. |",
           "| `torque_constant` | N.m/A | none |  | Torque per ampere. |",
           "### `damping[]` with `\"kind\": \"rc\"`",
           "| `sense` |  | `\"total\"` | `total`, `motor` | Where it measures. |",
           "Exactly one of `resistance`, `fraction` must be given.",
           "| `order` |  | `1` | whole number at least 1 and below 5 |  |",
       }) {
    EXPECT_NE(manual.find(part), std::string::npos) << part << "\nis not in\n" << manual;
  }
}

TEST(WriteManualTable, objects_alike_share_a_section) {
  const Member velocity = member::variant(
      "velocity", {{"difference", "Backward.", {member::integer("window").by_default(1)}}});
  const ObjectSpec spec{"",
                        "",
                        {member::object("wall", {"", "A wall.", {velocity}}),
                         member::object("proxy", {"", "A proxy.", {velocity}})}};
  const std::string manual = write_manual_table(spec);
  EXPECT_NE(manual.find("### `wall.velocity`, `proxy.velocity` with `\"kind\": \"difference\"`"),
            std::string::npos)
      << manual;
  EXPECT_EQ(manual.find("Backward."), manual.rfind("Backward."));
}

TEST(WriteManualTable, places_that_differ_in_one_choice_are_written_as_one) {
  const ObjectSpec fast{"fast", "Quick.", {member::integer("order").required()}};
  const Member with_fast = member::variant("filter", {fast, {"none", "Nothing.", {}}});
  const auto law = [&](const char* name) { return ObjectSpec{name, "A law.", {with_fast}}; };
  const Member root = member::variant(
      "",
      {{"rotary",
        "",
        {member::variant("law", {law("a"), law("b"), {"c", "", {}}}), member::boolean("only")}},
       {"linear", "", {member::variant("law", {law("a"), law("b"), {"c", "", {}}})}}},
      "motion");
  const std::string manual = write_manual_table(root);
  EXPECT_NE(manual.find("### `(*).law(a, b).filter` with `\"kind\": \"fast\"`\n\nQuick."),
            std::string::npos)
      << manual;
  EXPECT_EQ(manual.find("Quick."), manual.rfind("Quick."));
}

TEST(WriteManualTable, only_choice_at_a_place_is_named) {
  const ObjectSpec noise{"noise", "Noise.", {member::integer("seed")}};
  const ObjectSpec fast{"fast", "Quick.", {member::object("noise", noise)}};
  const ObjectSpec spec{"", "", {member::variant("filter", {fast})}};
  const std::string manual = write_manual_table(spec);
  EXPECT_NE(manual.find("### `filter(fast).noise`\n"), std::string::npos) << manual;
}

TEST(WriteManualTable, object_that_lacks_a_key_shares_the_section_and_is_told) {
  const Member one = member::integer("one");
  const Member two = member::integer("two");
  const Member extra = member::integer("extra");
  const auto law = [](std::vector<Member> members) {
    return std::vector<ObjectSpec>{{"wall", "A wall.", std::move(members)}};
  };
  const auto manual_of = [&](std::vector<Member> inner) {
    return write_manual_table(ObjectSpec{"",
                                         "",
                                         {member::variant("law", law({one, extra, two})),
                                          member::variant("inner", law(std::move(inner)))}});
  };
  const std::string shared = manual_of({one, two});
  EXPECT_NE(shared.find("### `law`, `inner` with `\"kind\": \"wall\"`\n"), std::string::npos)
      << shared;
  EXPECT_NE(shared.find("\nIn `inner` without `extra`.\n"), std::string::npos) << shared;
  // In another order, with another row, or with little in common: a table of its own.
  for (const auto& inner : std::vector<std::vector<Member>>{
           {two, one}, {one, member::integer("two").required()}, {one, two, extra, one}, {one}}) {
    EXPECT_NE(manual_of(inner).find("### `inner` with"), std::string::npos) << manual_of(inner);
  }
}

TEST(WriteManualTable, bar_inside_a_cell_is_escaped) {
  const ObjectSpec spec{"", "", {member::boolean("a").doc("x | y")}};
  EXPECT_NE(write_manual_table(spec).find("x \\| y"), std::string::npos);
}

// A document whose motor may have tolerances, but for its inductance.
Member make_toleranced_root() {
  ObjectSpec device = make_device();
  device.members[1].objects.front() =
      allow_tolerances(device.members[1].objects.front(), {"inductance"});
  return member::object("", device);
}

TEST(ReadTolerances, normal_form_has_the_nominal_value_and_the_rest_is_handed_out) {
  const json document = {
      {"motor", {{"resistance", "2 ohm ± 5 %"}, {"torque_constant", "40 mN.m/A to 60 mN.m/A"}}}};
  const ReadDocument read = read_document_with_tolerances(document, make_toleranced_root(), "d");
  EXPECT_EQ(read.normal["motor"]["resistance"], 2.0);
  EXPECT_EQ(read.normal["motor"]["torque_constant"], 0.05);
  ASSERT_EQ(read.tolerances.size(), 2U);
  EXPECT_EQ(read.tolerances[0].pointer, "/motor/resistance");
  EXPECT_EQ(read.tolerances[0].unit, dimension::resistance);
  EXPECT_EQ(read.tolerances[0].value, (TolerancedValue{2, 1.9, 2.1}));
  EXPECT_EQ(read.tolerances[0].text, "2 ohm ± 5 %");
  EXPECT_EQ(read.tolerances[1].pointer, "/motor/torque_constant");
}

TEST(ReadTolerances, one_of_no_width_is_none) {
  const json document = {{"motor", {{"resistance", "2 ohm ± 0 %"}}}};
  EXPECT_TRUE(
      read_document_with_tolerances(document, make_toleranced_root(), "d").tolerances.empty());
}

std::string find_tolerance_refusal(const json& motor) {
  try {
    read_document_with_tolerances({{"motor", motor}}, make_toleranced_root(), "d");
  } catch (const Error& error) {
    return error.place() + ": " + error.message();
  }
  return "no error";
}

TEST(ReadTolerances, both_ends_must_be_allowed_and_the_message_says_which_is_not) {
  EXPECT_EQ(find_tolerance_refusal({{"resistance", "2 ohm ± 120 %"}}),
            "d: /motor/resistance: \"2 ohm ± 120 %\" is at its low end -0.3999999999999999 ohm: "
            "must be above 0 ohm, for a winding loses energy");
  const json device = {{"motor", {{"resistance", 2}}},
                       {"damping", {{{"kind", "cancellation"}, {"fraction", "0.9 +20 % -0 %"}}}}};
  Member root = make_toleranced_root();
  root.objects.front().members[2].objects[2].members[1].takes_tolerance = true;
  try {
    read_document_with_tolerances(device, root, "d");
    ADD_FAILURE() << "1.08 is above 1";
  } catch (const Error& error) {
    EXPECT_NE(error.message().find("at its high end 1.08"), std::string::npos) << error.message();
  }
}

TEST(ReadTolerances, where_none_is_possible_the_message_says_so) {
  const char* expected = "no tolerance is possible here: write one value, such as \"0.5 mH\"";
  EXPECT_NE(
      find_tolerance_refusal({{"resistance", 2}, {"inductance", "1 mH ± 5 %"}}).find(expected),
      std::string::npos);
  EXPECT_NE(find_refusal(with("/period", "1 ms ± 1 %")).message.find("no tolerance is possible"),
            std::string::npos);
}

TEST(ReadTolerances, schema_and_manual_say_where_one_is_possible) {
  const std::string schema = write_json_schema(make_toleranced_root(), "x");
  EXPECT_NE(schema.find(R"(With a tolerance: \"1.5 ohm ± 5 %\".)"), std::string::npos);
  EXPECT_EQ(schema.find("0.5 mH ± 5 %"), std::string::npos);
  const std::string manual = write_manual_table(make_toleranced_root());
  EXPECT_NE(manual.find("| `resistance` | ohm ± | required |"), std::string::npos) << manual;
  EXPECT_NE(manual.find("| `inductance` | H | "), std::string::npos);
}

}  // namespace
}  // namespace gyrator
