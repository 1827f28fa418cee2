#include "gyrator/studies/design_section.hpp"

#include "gyrator/studies/result_figures.hpp"

#include <gtest/gtest.h>

#include "sample_results.hpp"

namespace gyrator {
namespace {

using nlohmann::json;

TEST(DesignSection, ADesignIsNamedWithItsPartsAndWhatIsLeft) {
  EXPECT_EQ(verdict_sentence(sample_design()),
            "Best design: rc (2.4 ohm, pre-emphasis), passive up to 0.11 N·m/rad; rated at 0.099 "
            "N·m/rad, which 82 % of the devices keep.");
  EXPECT_NE(report_section(sample_design()).html.find("50 %"), std::string::npos);
  auto none = sample_design();
  none["feasible"] = false;
  none["designs"] = json::array();
  none["binding_constraint"] = {
      {"name", "apparent_inertia"}, {"unit", "kg.m^2"},    {"limit", 1e-7}, {"needed", 2e-7},
      {"topology", "rc"},           {"enough_alone", true}};
  EXPECT_TRUE(is_bad_news(none));
  EXPECT_NE(verdict_sentence(none).find("would have to give to 2×10⁻⁷ kg·m² (rc)."),
            std::string::npos);
  none["fronts"] = json::array();
  EXPECT_EQ(result_figure(none).panels.size(), 1U);
}

}  // namespace
}  // namespace gyrator
