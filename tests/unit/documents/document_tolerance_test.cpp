#include "gyrator/core/error.hpp"
#include "gyrator/documents/document_manual.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/document_schema.hpp"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "document_example.hpp"

namespace gyrator {
namespace {

using namespace documents_tests;
using nlohmann::json;

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
