#include "gyrator/core/error.hpp"
#include "gyrator/core/rational.hpp"
#include "gyrator/documents/document_reader.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "document_example.hpp"

namespace gyrator {
namespace {

using namespace documents_tests;
using nlohmann::json;

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

}  // namespace
}  // namespace gyrator
