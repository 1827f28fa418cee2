#include "gyrator/studies/report.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/studies/report_sections.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_figures.hpp"

#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <gtest/gtest.h>

#include "sample_results.hpp"
#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

using nlohmann::json;

std::vector<json> all_samples() {
  return {sample_passivity(), sample_zwidth(),        sample_simulate(),  sample_compare(),
          sample_impedance(), sample_stability_map(), sample_tolerance(), sample_two_port(),
          sample_envelope(),  sample_environment(),   sample_workspace(), sample_identification(),
          sample_tuning(),    sample_design()};
}

/// What a reader sees: scripts and tags taken out.
std::string shown_text(std::string html) {
  for (auto from = html.find("<script"); from != std::string::npos; from = html.find("<script"))
    html.erase(from, html.find("</script>", from) + 9 - from);
  return std::regex_replace(html, std::regex("<[^>]*>"), " ");
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// The page without its own script.
std::string without_script(std::string html) {
  const auto from = html.find("<script>");
  if (from != std::string::npos) html.erase(from, html.find("</script>", from) - from);
  return html;
}

const Curve* find_curve(const Panel& panel, const std::string& title) {
  for (const auto& curve : panel.curves)
    if (curve.title == title) return &curve;
  return nullptr;
}

TEST(Report, IsOneWellFormedPageThatLoadsNothing) {
  const auto html = report_as_html(all_samples());
  std::istringstream stream(html);
  boost::property_tree::ptree tree;
  EXPECT_NO_THROW(boost::property_tree::read_xml(stream, tree));
  // The only scripts are the program's own and the figures' data.
  EXPECT_EQ(count_of(html, "<script"), count_of(html, "<script type=\"application/json\"") + 1);
  EXPECT_EQ(count_of(html, "<link"), 0U);
  EXPECT_EQ(count_of(without_script(html), "src="), 0U);
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(html.find("@import"), std::string::npos);
  // The only addresses are the names of XML vocabularies.
  static const std::regex address(R"(https?://[^"' ]*)");
  for (std::sregex_iterator at(html.begin(), html.end(), address), end; at != end; ++at)
    EXPECT_TRUE(at->str().starts_with("http://www.w3.org/")) << at->str();
}

TEST(Report, OpensWithTheVerdictAndTheFinding) {
  const auto text = shown_text(report_as_html(all_samples()));
  const auto verdict = text.find("Not passive: with a wall of stiffness 0.4 N·m/rad");
  const auto finding = text.find("allows 0.5 N·m/rad here");
  const auto truth = text.find("is 0.0658 N·m/rad: the textbook is 7.6 times too high");
  const auto section = text.find("Passivity: RC-damped display");
  ASSERT_NE(verdict, std::string::npos) << text;
  ASSERT_NE(finding, std::string::npos);
  ASSERT_NE(truth, std::string::npos);
  ASSERT_NE(section, std::string::npos);
  EXPECT_LT(verdict, finding);
  EXPECT_LT(finding, truth);
  EXPECT_LT(truth, section);
  EXPECT_NE(text.find("The proof is a plain inertia of 3.6×10⁻³ kg·m² held in the hand"),
            std::string::npos);
}

TEST(Report, SaysNothingOfAFindingWhereTheCriteriaAgree) {
  auto passivity = sample_passivity();
  passivity["verdict"] = "passive";
  passivity["criteria"] = {sample_criterion("frequency_dependent", true, 0.5),
                           sample_criterion("exact_disk", true, 0.49)};
  passivity["counterexample"] = nullptr;
  const auto html = report_as_html({passivity, sample_zwidth()});
  EXPECT_EQ(html.find("The finding"), std::string::npos);
  EXPECT_NE(html.find("Passive: with a wall"), std::string::npos);
}

TEST(Report, TellsATextbookThatIsTooStrictFromOneThatIsUnsafe) {
  auto passivity = sample_passivity();
  passivity["verdict"] = "passive";
  passivity["criteria"] = {sample_criterion("frequency_dependent", false, 0.1),
                           sample_criterion("exact_disk", true, 0.5)};
  passivity["counterexample"] = nullptr;
  const auto html = report_as_html({passivity});
  EXPECT_NE(html.find("The textbook refuses walls"), std::string::npos);
  EXPECT_EQ(html.find("too high"), std::string::npos);
}

TEST(Report, HasTheCriteriaTableAndTheEnergyLedgerWithItsResidual) {
  const auto text = shown_text(report_as_html(all_samples()));
  for (const char* part : {"Criterion", "Worst frequency", "reason of exact_disk", "13.1 Hz",
                           "0.0658 N·m/rad", "Residual", "4.25×10⁻¹⁸ J", "−9×10⁻⁶ J"})
    EXPECT_NE(text.find(part), std::string::npos) << part;
}

TEST(Report, TheLedgerTakesTheEnergyStoredAtTheStartOff) {
  auto simulate = sample_simulate();
  simulate["energy"]["stored"] = 1e-6;
  simulate["energy"]["stored_initially"] = 3.5e-6;
  EXPECT_NE(report_as_html({simulate}).find("−2.5×10⁻⁶ J"), std::string::npos);
}

TEST(Report, EndsWithModelCommandLinesAndProgramVersion) {
  const auto html = report_as_html(all_samples());
  for (const char* part : {"gyrator simulate device.json --json", "gyrator 1.2.3",
                           "&quot;schema&quot;: &quot;gyrator/model/1&quot;"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  // The same model in four results is shown once.
  EXPECT_EQ(html.find("&quot;schema&quot;"), html.rfind("&quot;schema&quot;"));
}

TEST(Report, EscapesEveryTextOfTheUser) {
  const std::string nasty = "<script>alert(1)</script> & \"q\" 'a' _{x}^2";
  auto results = all_samples();
  for (auto& result : results) {
    result["model_name"] = nasty;
    result["model"]["name"] = nasty;
    result["command_line"] = nasty;
    result["program"] = nasty;
    result["units"]["stiffness"] = nasty;
    result["units"]["position"] = nasty;
  }
  for (auto& criterion : results[0]["criteria"]) criterion["reason"] = nasty;
  results[0]["criteria"].push_back(sample_criterion(nasty, true, 1));
  results[0]["explanation"] = nasty;
  results[0]["counterexample"]["simulation"]["classification"] = nasty;
  results[1]["boundaries"][0]["criterion"] = nasty;
  results[2]["classification"] = nasty;
  const auto html = report_as_html(results);
  EXPECT_EQ(html.find("<script>alert"), std::string::npos);
  EXPECT_NE(html.find("&lt;script"), std::string::npos);
  std::istringstream stream(html);
  boost::property_tree::ptree tree;
  EXPECT_NO_THROW(boost::property_tree::read_xml(stream, tree));
}

TEST(Report, IdsOnThePageAreUnique) {
  const auto html = report_as_html(all_samples());
  static const std::regex id(R"(<[^>]* id=['"]([^'"]*)['"])");
  std::set<std::string> seen;
  for (std::sregex_iterator at(html.begin(), html.end(), id), end; at != end; ++at)
    EXPECT_TRUE(seen.insert((*at)[1]).second) << (*at)[1];
  EXPECT_GT(seen.size(), 50U);
}

TEST(Report, RefusesAnUnknownCommandAndListsTheKnownOnes) {
  const ScratchFolder folder;
  auto strange = sample_base("teleport");
  try {
    write_report({sample_simulate(), strange}, folder / "report.html");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    const std::string text = error.what();
    EXPECT_NE(text.find("result 2 of 2"), std::string::npos) << text;
    EXPECT_NE(text.find("'teleport'"), std::string::npos) << text;
    EXPECT_NE(text.find("simulate, stability-map, tolerance, tune, twoport, workspace, zwidth"),
              std::string::npos)
        << text;
  }
  EXPECT_EQ(folder.count(), 0U) << "nothing may be left behind";
}

TEST(Report, NamesResultCommandAndKeyWhereAKeyIsMissing) {
  auto simulate = sample_simulate();
  simulate["energy"].erase("residual");
  try {
    report_as_html({simulate});
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "report: result 1 of 1: simulate result: /energy: /residual: is missing");
  }
}

TEST(Report, NamesTheFileThatAResultCameFrom) {
  auto simulate = sample_simulate();
  simulate["energy"].erase("residual");
  try {
    report_as_html({sample_simulate(), simulate}, {"a.json", "b.json"});
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "b.json: simulate result: /energy: /residual: is missing");
  }
}

TEST(Report, RefusesWhatIsNoResultAtAll) {
  EXPECT_THROW(report_as_html({}), Error);
  for (const json& junk : {json(3), json::array(), json::object(), json("text")})
    EXPECT_THROW(report_as_html({junk}), Error) << junk;
}

TEST(Report, RefusesWrongKindsWithAnErrorRatherThanACrash) {
  // Every member of every sample in turn becomes something else.
  for (const auto& sample : all_samples())
    for (const auto& [key, value] : sample.items())
      for (const json& junk : {json(3), json("x"), json::array({json("x")}), json::object()}) {
        if (key == "command") continue;
        auto broken = sample;
        broken[key] = junk;
        try {
          verdict_sentence(broken);
          report_section(broken);
          result_figure(broken);
          finding_in_words(broken);
        } catch (const Error&) {
        } catch (const std::exception& error) {
          ADD_FAILURE() << sample["command"] << " " << key << " = " << junk << ": " << error.what();
        }
      }
}

TEST(Report, IsWrittenWholeToItsFile) {
  const ScratchFolder folder;
  write_report({sample_simulate()}, folder / "report.html");
  EXPECT_EQ(read_text(folder / "report.html"), report_as_html({sample_simulate()}));
  EXPECT_EQ(folder.count(), 1U);
}

TEST(Report, ItsFiguresAreWrittenAsSvgFilesByPlaceAndCommand) {
  const ScratchFolder folder;
  const auto into = folder / "figures";
  const auto paths = write_report_figures({sample_passivity(), sample_zwidth()}, into);
  std::vector<std::string> names;
  for (const auto& path : paths) {
    names.push_back(std::filesystem::path(path).filename().string());
    EXPECT_NE(read_text(path).find("<svg"), std::string::npos) << path;
  }
  EXPECT_EQ(names, (std::vector<std::string>{"finding.svg", "1-passivity.svg", "2-zwidth.svg"}));
}

TEST(Report, AFolderForFiguresThatCannotBeMadeIsRefusedByName) {
  const ScratchFolder folder;
  write_report({sample_zwidth()}, folder / "page.html");
  try {
    write_report_figures({sample_zwidth()}, folder / "page.html");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_NE(std::string(error.what()).find("page.html"), std::string::npos) << error.what();
  }
}

TEST(Report, SaysWhatEnvironmentAndWorkspaceComeTo) {
  const auto text = shown_text(report_as_html({sample_environment(), sample_workspace()}));
  EXPECT_NE(text.find("Not shown to be passive"), std::string::npos) << text;
  EXPECT_NE(text.find("the sensor is not at the port"), std::string::npos);
  EXPECT_NE(text.find("Not enough: at the pose far"), std::string::npos) << text;
}

TEST(ResultFigures, AnIdentificationShowsWhatEachFitLeaves) {
  const Figure figure = result_figure(sample_identification());
  ASSERT_EQ(figure.panels.size(), 6U);
  // Sizes and phases are those of the samples: the fit leaves nothing.
  for (const Curve& curve : figure.panels[2].curves)
    for (const double rest : curve.y) EXPECT_NEAR(rest, 0, 1e-9);
  // 1e-5 · 100 + 1e-3 = 0.002, and so on: the line goes through all four.
  for (const double rest : figure.panels[5].curves[0].y) EXPECT_NEAR(rest, 0, 1e-12);
}

TEST(Report, AnIdentificationNamesWhatCouldNotBeFound) {
  const auto sentence = verdict_sentence(sample_identification());
  EXPECT_NE(sentence.find("1 of 2 parameters"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("not identifiable: bandwidth"), std::string::npos) << sentence;
  const auto section = report_section(sample_identification());
  EXPECT_NE(section.html.find("no command"), std::string::npos);
}

TEST(ResultFigures, EveryCommandHasOne) {
  ASSERT_EQ(known_result_commands().size(), all_samples().size());
  for (const auto& sample : all_samples()) EXPECT_FALSE(result_figure(sample).panels.empty());
}

TEST(ResultFigures, ComparedDesignsAreShownFromWhereTheLowestBoundaryStarts) {
  const auto panel = comparison_figure(sample_compare()).panels.at(0);
  ASSERT_EQ(panel.curves.size(), 2U);
  EXPECT_EQ(panel.curves[1].title, "cancelled");
  EXPECT_DOUBLE_EQ(panel.y_axis.min.value(), 0.7 * 0.01 / 2);
}

TEST(Report, ADesignThatOscillatesWhenColdIsSaidTo) {
  const auto text = shown_text(report_as_html({sample_compare()}));
  EXPECT_NE(text.find("unstable"), std::string::npos);
  EXPECT_NE(text.find("× 0.5"), std::string::npos);
}

TEST(ResultFigures, NegativeDampingIsShownApartAsItsMagnitude) {
  const auto panel = impedance_figure(sample_impedance()).panels.at(0);
  const auto* damping = find_curve(panel, "Re Z, effective damping");
  const auto* active = find_curve(panel, "−Re Z where Re Z < 0 (active)");
  ASSERT_TRUE(damping && active);
  EXPECT_TRUE(std::isnan(damping->y[1]));
  EXPECT_DOUBLE_EQ(active->y[1], 2e-4);
  EXPECT_NE(active->colour, damping->colour);
}

TEST(ResultFigures, ThePhaseOfTheActuationPathDoesNotJump) {
  auto result = sample_base("impedance");
  std::vector<double> frequency;
  std::vector<double> real;
  std::vector<double> imag;
  for (int i = 0; i < 100; ++i) {
    frequency.push_back(1 + i);
    real.push_back(std::cos(-0.1 * i));
    imag.push_back(std::sin(-0.1 * i));
  }
  result["frequency_hz"] = frequency;
  result["impedance_real"] = real;
  result["impedance_imag"] = imag;
  result["actuation_real"] = real;
  result["actuation_imag"] = imag;
  const auto phase = impedance_figure(result).panels.at(2).curves.at(0).y;
  const double degrees = 180 / std::acos(-1.0);
  EXPECT_NEAR(phase.back(), -9.9 * degrees, 1e-9);
}

TEST(ResultFigures, TheDiskPanelSaysOnWhichSideTheCriticalPointIs) {
  auto result = sample_passivity();
  const auto title = [&] { return passivity_figure(result).panels.at(2).title; };
  EXPECT_NE(title().find("inside"), std::string::npos) << title();
  result["disk"]["critical_imag"] = 1.0;  // beyond the rim at 0.2
  EXPECT_NE(title().find("outside"), std::string::npos) << title();
}

TEST(ResultFigures, TheCloseUpShowsTheCriticalPointOnItsSideOfTheRimHoweverLargeTheDisk) {
  auto result = sample_passivity();
  // Of the RC-damped display at 6e-5 Hz: inside by 3.2e-6, the disk 1e13 times as large.
  result["disk"] = {{"frequency_hz", 6.163e-5},
                    {"center_real", -18.999999997249418},
                    {"center_imag", -12911167.831259638},
                    {"radius", 12911167.831273627},
                    {"critical_real", -2.4999999999998765},
                    {"critical_imag", 3.6305778537429394e-07}};
  const auto panel = passivity_figure(result).panels.at(3);
  EXPECT_EQ(panel.title.find("Close-up: −1/H is 3."), 0U) << panel.title;
  EXPECT_NE(panel.title.find("inside the rim"), std::string::npos) << panel.title;
  const auto& rim = panel.curves.at(0);
  const double height = panel.markers.at(0).y;
  EXPECT_LT(height, 0);
  EXPECT_DOUBLE_EQ(rim.y.at(60), 0);                       // the foot of the critical point
  EXPECT_NEAR(rim.y.front(), 3 * height, 1e-2 * -height);  // the rim curves away in sight
}

TEST(ResultFigures, ABoundaryEndsWhereNoStiffnessIsAllowed) {
  auto result = sample_zwidth();
  result["boundaries"][0]["feasible"] = {true, false, false};
  const auto curve = zwidth_figure(result).panels.at(0).curves.at(0);
  EXPECT_EQ(curve.y[0], 0.2);
  EXPECT_EQ(curve.y[1], 0);  // down to the axis
  EXPECT_TRUE(std::isnan(curve.y[2]));
}

TEST(ResultFigures, FrequenciesWhereTheExactDampingIsNegativeAreShaded) {
  const auto panel = passivity_figure(sample_passivity()).panels.at(0);
  const auto* shade = find_curve(panel, "fails here (exact)");
  ASSERT_TRUE(shade);
  EXPECT_TRUE(std::isfinite(shade->y[0]));
  EXPECT_TRUE(std::isnan(shade->y[1]));
  EXPECT_TRUE(std::isnan(shade->y[2]));
}

TEST(ResultFigures, AGrowingRunIsCutWhereALinearAxisCannotShowItsBeginning) {
  auto result = sample_passivity();
  auto& run = result["counterexample"]["simulation"];
  std::vector<double> position;
  for (int i = 0; i < 200; ++i) position.push_back(std::exp(0.5 * i));
  run["position"] = position;
  const auto shown = finding_figure(result, nullptr).panels.at(0).curves.at(0);
  EXPECT_LT(shown.y.size(), 100U);
  EXPECT_LE(shown.y.back(), 30 * std::exp(0.5 * 19));
  EXPECT_EQ(shown.x.size(), shown.y.size());
}

TEST(ResultFigures, TheFindingShadesWhatTheTextbookWronglyCallsPassive) {
  const auto figure = finding_figure(sample_passivity(), sample_zwidth());
  ASSERT_EQ(figure.panels.size(), 2U);
  const auto* band = find_curve(figure.panels[0], "passive by the textbook, yet not");
  ASSERT_TRUE(band);
  EXPECT_EQ(band->style, CurveStyle::band);
  EXPECT_EQ(band->y, (std::vector<double>{0.55, 0.52, 0.49}));
  EXPECT_EQ(band->y_low, (std::vector<double>{0.02, 0.06, 0.07}));
  ASSERT_EQ(figure.panels[0].markers.size(), 3U);
  EXPECT_EQ(figure.panels[0].markers[0].label, "this model, K = 0.4");
  EXPECT_EQ(figure.panels[1].title, "A plain inertia of 3.6×10⁻³ kg·m² held in the hand: diverges");
}

TEST(ResultFigures, OperatorsAreNamedByWhatTheyAreMadeOf) {
  auto result = sample_passivity();
  auto& example = result["counterexample"];
  EXPECT_EQ(operator_in_words(result), "a plain inertia of 3.6×10⁻³ kg·m² held in the hand");
  example["stiffness"] = 2.0;
  EXPECT_EQ(operator_in_words(result),
            "an inertia of 3.6×10⁻³ kg·m² held by a spring of 2 N·m/rad");
  example["inertia"] = 0;
  EXPECT_EQ(operator_in_words(result), "a spring of 2 N·m/rad held against the handle");
  example["stiffness"] = 0;
  EXPECT_EQ(operator_in_words(result), "the handle let go, nothing attached");
  EXPECT_TRUE(passivity_figure(result).panels.at(4).title.starts_with("The handle let go"));
  example["resonators"] = {1, 2};
  EXPECT_NE(operator_in_words(result).find("2 resonators"), std::string::npos);
}

}  // namespace
}  // namespace gyrator
