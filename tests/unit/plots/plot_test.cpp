#include "gyrator/plots/plot.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/plots/plot_axes.hpp"
#include "gyrator/plots/plot_labels.hpp"
#include "gyrator/plots/plot_page.hpp"
#include "gyrator/plots/plot_script.hpp"
#include "gyrator/plots/pretty_text.hpp"

#include <cmath>
#include <cstdlib>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <gtest/gtest.h>

#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

/// Throws where the tags do not match.
void parse_xml(const std::string& text) {
  std::istringstream stream(text);
  boost::property_tree::ptree tree;
  boost::property_tree::read_xml(stream, tree);
}

Figure make_figure() {
  Panel panel{"Run", {"time", "s"}, {"position", "rad"}};
  panel.curves = {{"handle", {0, 1, 2, 3}, {0, 1, 0, -1}},
                  {"command", {0, 1, 2, 3}, {1, 0, 1, 0}, CurveStyle::steps, Colour::orange}};
  panel.markers = {{1, 1, "a marked point"}};
  panel.lines = {{0, false}};
  return {"A figure", {panel}};
}

/// All ids that the SVG defines.
std::multiset<std::string> ids_of(const std::string& svg) {
  static const std::regex id(R"(<[^>]* id=['"]([^'"]*)['"])");
  std::multiset<std::string> ids;
  for (std::sregex_iterator at(svg.begin(), svg.end(), id), end; at != end; ++at)
    ids.insert((*at)[1]);
  return ids;
}

TEST(Plot, AnSvgIsWellFormedAndHasAllItsTexts) {
  const auto svg = figure_as_svg(make_figure());
  EXPECT_NO_THROW(parse_xml(svg));
  for (const char* text :
       {"A figure", "Run", "handle", "command", "a marked point", "time [s]", "position [rad]"})
    EXPECT_NE(svg.find(text), std::string::npos) << text;
}

TEST(Plot, AnEmbeddedSvgBeginsWithItsElement) {
  EXPECT_TRUE(figure_as_svg(make_figure()).starts_with("<svg"));
}

TEST(Plot, IdsOfTwoFiguresOnOnePageDiffer) {
  const auto first = ids_of(figure_as_svg(make_figure(), "first"));
  const auto second = ids_of(figure_as_svg(make_figure(), "second"));
  ASSERT_GT(first.size(), 5U);
  EXPECT_EQ(first.size(), second.size());
  for (const auto& id : first) {
    EXPECT_EQ(first.count(id), 1U) << id;
    EXPECT_EQ(second.count(id), 0U) << id;
  }
}

TEST(Plot, EveryReferenceInAnSvgHasItsTarget) {
  // "g" begins gnuplot's own ids too: these must get the prefix all the same.
  const auto svg = figure_as_svg(make_figure(), "g");
  const auto ids = ids_of(svg);
  static const std::regex reference(R"(href=['"]#([^'"]*)['"]|url\(#([^)]*)\))");
  int references = 0;
  for (std::sregex_iterator at(svg.begin(), svg.end(), reference), end; at != end; ++at) {
    const std::string id = (*at)[1].matched ? (*at)[1] : (*at)[2];
    EXPECT_EQ(ids.count(id), 1U) << id;
    EXPECT_TRUE(id.starts_with("g_")) << id;
    ++references;
  }
  EXPECT_GT(references, 0);
}

TEST(Plot, RefusesAnIdThatIsNoName) {
  for (const char* id : {"", "1st", "a b", "a'b", "a-b"})
    EXPECT_THROW(figure_as_svg(make_figure(), id), Error) << id;
}

TEST(Plot, MarkupAndCommandsInTextsStayText) {
  const ScratchFolder folder;
  const std::string created = folder / "created";
  const std::string nasty = "<script>x</script> & a_{b}^c it's \"q\" `touch " + created +
                            "` \\\\ @x $(y) \n plot sin(x) \x01 \xff";
  auto figure = make_figure();
  figure.title = nasty;
  figure.panels[0].title = nasty;
  figure.panels[0].x_axis.label = nasty;
  figure.panels[0].y_axis.unit = nasty;
  figure.panels[0].curves[0].title = nasty;
  figure.panels[0].markers[0].label = nasty;
  const auto svg = figure_as_svg(figure);
  EXPECT_NO_THROW(parse_xml(svg));
  EXPECT_EQ(svg.find("<script"), std::string::npos);
  EXPECT_NE(svg.find("&lt;script"), std::string::npos);
  EXPECT_NE(svg.find("a_{b}^c it's"), std::string::npos) << "shown as typed";
  EXPECT_EQ(folder.count(), 0U) << "a command in a text was run";
}

TEST(Plot, WritesAPngWithItsSignatureAndNothingElse) {
  const ScratchFolder folder;
  render_figure(make_figure(), folder / "figure.png");
  const auto png = read_text(folder / "figure.png");
  EXPECT_TRUE(png.starts_with("\x89PNG\r\n\x1a\n"));
  EXPECT_NE(png.find("IEND"), std::string::npos);
  EXPECT_EQ(folder.count(), 1U);
}

TEST(Plot, WritesAnSvgFileThatIsWellFormed) {
  const ScratchFolder folder;
  render_figure(make_figure(), folder / "figure.SVG");
  EXPECT_NO_THROW(parse_xml(read_text(folder / "figure.SVG")));
  EXPECT_EQ(folder.count(), 1U);
}

TEST(Plot, RefusesOtherExtensionsAndNamesTheTwoItKnows) {
  const ScratchFolder folder;
  for (const char* name : {"figure.pdf", "figure", "svg"}) {
    try {
      render_figure(make_figure(), folder / name);
      FAIL() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(error.message().find(".svg or .png"), std::string::npos) << error.what();
    }
  }
  EXPECT_EQ(folder.count(), 0U);
}

TEST(Plot, ValuesThatAreNoNumbersBreakTheLineAndNotThePlot) {
  auto figure = make_figure();
  figure.panels[0].curves = {{"gap", {0, 1, 2, 3, 4}, {0, 1, NAN, 1, INFINITY}}};
  const auto script = gnuplot_script(figure, PlotFormat::svg_file, "figure");
  EXPECT_NE(script.find("0 0 0\n1 1 1\n\n3 1 1\n\nEND_OF_DATA"), std::string::npos) << script;
  EXPECT_NO_THROW(figure_as_svg(figure));
}

TEST(Plot, ValuesThatALogarithmicAxisCannotShowBreakTheLine) {
  auto figure = make_figure();
  figure.panels[0].y_axis.logarithmic = true;
  figure.panels[0].curves = {{"gap", {0, 1, 2, 3}, {10, -1, 0, 1000}}};
  const auto script = gnuplot_script(figure, PlotFormat::svg_file, "figure");
  EXPECT_NE(script.find("0 10 10\n\n3 1000 1000\n"), std::string::npos) << script;
  EXPECT_NO_THROW(figure_as_svg(figure));
}

TEST(Plot, AFigureWithoutAnyNumberStillHasAxes) {
  for (const bool logarithmic : {false, true}) {
    Figure figure{"Empty", {{"nothing", {"x", "s", logarithmic}, {"y", "m", logarithmic}}}};
    figure.panels[0].curves = {{"none", {NAN, 1}, {1, NAN}}, {"empty", {}, {}}};
    EXPECT_NE(figure_as_svg(figure).find("y [m]"), std::string::npos);
  }
}

TEST(Plot, HugeTinyAndConstantValuesAreDrawn) {
  for (const double value : {0.0, 1e-310, 1e-30, -7.0, 1e150, 1e300}) {
    auto figure = make_figure();
    figure.panels[0].curves = {{"constant", {0, 1}, {value, value}}};
    EXPECT_NO_THROW(figure_as_svg(figure)) << value;
  }
}

TEST(Plot, ALongCurveKeepsItsExtremesInAFewThousandPoints) {
  Figure figure{"", {{"", {"x"}, {"y"}}}};
  Curve curve{"long", {}, {}};
  for (int i = 0; i < 200000; ++i) {
    curve.x.push_back(1e-4 * i);
    curve.y.push_back(i == 123457 ? 50 : i % 2);
  }
  figure.panels[0].curves = {curve};
  const auto script = gnuplot_script(figure, PlotFormat::svg_file, "figure");
  EXPECT_LT(std::count(script.begin(), script.end(), '\n'), 4000);
  EXPECT_NE(script.find("\n12.3457 50 50\n"), std::string::npos);
  EXPECT_NE(script.find("\n0 0 0\n"), std::string::npos);
  EXPECT_NE(script.find("\n19.9999 1 1\n"), std::string::npos);
}

TEST(Plot, EveryStyleIsAcceptedByGnuplot) {
  for (const auto style :
       {CurveStyle::line, CurveStyle::dashed, CurveStyle::dotted, CurveStyle::steps,
        CurveStyle::points, CurveStyle::impulses, CurveStyle::area, CurveStyle::band}) {
    auto figure = make_figure();
    figure.panels[0].curves = {{"c", {0, 1, 2}, {1, 2, 3}, style, Colour::green, {0, 1, 1}}};
    EXPECT_NO_THROW(figure_as_svg(figure)) << static_cast<int>(style);
  }
}

TEST(Plot, AnAxisWithNamesShowsThemInsteadOfNumbers) {
  Figure figure = make_figure();
  Panel named = figure.panels.front();
  named.y_axis = {"", "", false, 0.5, 2.5, {"a long name of a part", "it's & <b>"}};
  figure.panels.push_back(named);
  const std::string script = gnuplot_script(figure, PlotFormat::svg_file, "figure");
  EXPECT_NE(script.find("set ytics ('a long name of a part' 1, 'it''s & <b>' 2)"),
            std::string::npos);
  const std::string svg = figure_as_svg(figure);
  EXPECT_NO_THROW(parse_xml(svg));
  EXPECT_NE(svg.find("a long name of a part"), std::string::npos);
  // The frames line up, and the names have the room that they need.
  const Page page = lay_out(figure, 1);
  EXPECT_EQ(page.places[0].left, page.places[1].left);
  EXPECT_GT(page.places[1].left, text_width("a long name of a part"));
  EXPECT_GT(page.places[0].left, lay_out(make_figure(), 1).places[0].left);
}

TEST(Plot, RefusesCurvesOfUnequalLengthsAndNamesTheCurve) {
  auto figure = make_figure();
  figure.panels[0].curves[0].y.pop_back();
  try {
    figure_as_svg(figure);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(error.message().find("\"handle\": 4 values of x, 3 of y"), std::string::npos)
        << error.what();
  }
  EXPECT_THROW(figure_as_svg({"none", {}}), Error);
}

TEST(Plot, WithoutGnuplotTheErrorSaysWhatToInstall) {
  const auto without_gnuplot = [] {
    ::setenv("PATH", "/nonexistent", 1);
    try {
      figure_as_svg(make_figure());
    } catch (const Error& error) {
      std::_Exit(std::string(error.what()).find("gnuplot-nox") != std::string::npos ? 7 : 8);
    }
    std::_Exit(9);
  };
  EXPECT_EXIT(without_gnuplot(), testing::ExitedWithCode(7), "");
}

TEST(PlotAxes, ALinearAxisOfSmallNumbersIsShownInPowersOfTenOfItsUnit) {
  Panel panel{"", {"time", "s"}, {"damping", "N.m.s/rad"}};
  panel.curves = {{"", {0, 1}, {1e-4, 5e-4}}};
  const auto view = view_of(panel, 400, 300);
  EXPECT_EQ(view.y.label, "damping [10⁻⁶ N·m·s/rad]");
  EXPECT_DOUBLE_EQ(view.y.scaled(2e-4), 200);
  EXPECT_EQ(view.x.label, "time [s]");
}

TEST(PlotAxes, RangesHoldTheDataAndWhatTheAxisAsksFor) {
  Panel panel{"", {"x"}, {"y"}};
  panel.curves = {{"", {2, 7}, {-1, 3}}};
  panel.y_axis.max = 10;
  const auto view = view_of(panel, 400, 300);
  EXPECT_EQ(view.x.low, 2);
  EXPECT_EQ(view.x.high, 7);
  EXPECT_LT(view.y.low, -1);
  EXPECT_EQ(view.y.high, 10);
}

TEST(PlotAxes, WithEqualAspectOneUnitIsAsLongBothWays) {
  Panel panel{"", {"x"}, {"y"}};
  panel.circles = {{5, 5, 2}};
  panel.equal_aspect = true;
  const auto view = view_of(panel, 400, 300);
  EXPECT_NEAR((view.x.high - view.x.low) / 400, (view.y.high - view.y.low) / 300, 1e-12);
  EXPECT_LT(view.y.low, 3);
  EXPECT_GT(view.y.high, 7);
}

TEST(PlotAxes, ALogarithmicAxisShowsTwoDecadesAndIgnoresRoundingErrorsNearZero) {
  Panel panel{"", {"x"}, {"y", "", true}};
  panel.curves = {{"", {0, 1, 2}, {0.2, 0.9, 0.5}}};
  auto view = view_of(panel, 400, 300);
  EXPECT_LE(view.y.low, 0.1);
  EXPECT_GE(view.y.high, 1);
  panel.curves[0].y[0] = 1e-40;
  view = view_of(panel, 400, 300);
  EXPECT_GT(view.y.low, 1e-12);
}

TEST(PlotLabels, TheTextOfAMarkerKeepsClearOfCurvesAndOtherTexts) {
  // Both markers lie on a curve that rises through them: right of them is the curve's place.
  Panel panel{"", {"x"}, {"y"}};
  panel.curves = {{"", {0, 10}, {0, 10}}};
  panel.markers = {{4, 4, "a text of some length"}, {4.2, 4.2, "another such text"}};
  PanelPlace place;
  place.right = 500;
  place.bottom = 300;
  const auto view = view_of(panel, place.width(), place.height());
  const auto spots = place_labels(panel, view, place);
  ASSERT_EQ(spots.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const double right = spots[i].left + text_width(panel.markers[i].label);
    EXPECT_GE(spots[i].left, 0);
    EXPECT_LE(right, 500);
    // The curve's height in pixels over both ends of the text: the text is all above or below.
    const auto curve_at = [&](double x) { return 300 * (1 - view.y.fraction(10 * x / 500)); };
    const bool below = spots[i].middle - 8 > curve_at(spots[i].left);
    const bool above = spots[i].middle + 8 < curve_at(right);
    EXPECT_TRUE(above || below) << spots[i].left << " " << spots[i].middle;
  }
  const double apart = std::abs(spots[0].middle - spots[1].middle);
  const bool side_by_side = spots[0].left + text_width(panel.markers[0].label) <= spots[1].left ||
                            spots[1].left + text_width(panel.markers[1].label) <= spots[0].left;
  EXPECT_TRUE(apart >= 16 || side_by_side);
}

TEST(ResultText, NumbersAreShownToSensibleDigits) {
  EXPECT_EQ(pretty_number(0), "0");
  EXPECT_EQ(pretty_number(0.4), "0.4");
  EXPECT_EQ(pretty_number(0.0658), "0.0658");
  EXPECT_EQ(pretty_number(0.0036), "3.6×10⁻³");
  EXPECT_EQ(pretty_number(-12345.678), "−12346");
  EXPECT_EQ(pretty_number(0.99996), "1");
  EXPECT_EQ(pretty_number(1e12), "1×10¹²");
  EXPECT_EQ(pretty_number(NAN), "–");
  EXPECT_EQ(pretty_number(INFINITY), "∞");
  EXPECT_EQ(pretty_quantity(2.5, "kg.m^2"), "2.5 kg·m²");
}

}  // namespace
}  // namespace gyrator
