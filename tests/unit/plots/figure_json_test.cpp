#include "gyrator/plots/figure_json.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/digest.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/plots/interactive_figure.hpp"
#include "gyrator/plots/web_assets.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

using nlohmann::json;

Panel panel_of(std::vector<Curve> curves) {
  Panel panel{"Run", {"time", "s"}, {"position", "N.m"}};
  panel.curves = std::move(curves);
  return panel;
}

json parsed(const Panel& panel) {
  return json::parse(figure_as_json({"A figure", {panel}}));
}

/// A column of the panel's first curve.
json column(const json& figure, const char* name, std::size_t curve = 0) {
  return figure["numbers"].at(figure["panels"][0]["curves"].at(curve).at(name).get<std::size_t>());
}

TEST(FigureJson, HoldsAxesWithPrintedUnitsAndCurvesInDataUnits) {
  const auto figure = parsed(panel_of({{"handle", {0, 1, 2}, {1e-3, 2e-3, 4e-3}}}));
  const auto& panel = figure["panels"][0];
  EXPECT_EQ(panel["title"], "Run");
  EXPECT_EQ(panel["y"]["unit"], "N·m");
  EXPECT_EQ(panel["y"]["label"], "position [10⁻³ N·m]");
  EXPECT_EQ(panel["y"]["exponent"], -3);
  EXPECT_EQ(panel["curves"][0]["title"], "handle");
  EXPECT_EQ(panel["curves"][0]["style"], "line");
  EXPECT_EQ(column(figure, "x"), json({0, 1, 2}));
  EXPECT_EQ(column(figure, "y"), json({1e-3, 2e-3, 4e-3}));
}

TEST(FigureJson, WhatAnAxisCannotShowIsNull) {
  auto panel = panel_of({{"", {1, NAN, 3, 4}, {1, 2, -3, INFINITY}}});
  panel.y_axis.logarithmic = true;
  const auto figure = parsed(panel);
  EXPECT_EQ(column(figure, "y"), json({1, nullptr, nullptr, nullptr}));
  EXPECT_EQ(column(figure, "x"), json({1, 1, 3, 4})) << "x must stay in order, without gaps";
}

TEST(FigureJson, AListThatTwoCurvesShareIsThereOnce) {
  const auto figure = parsed(panel_of({{"a", {0, 1}, {5, 6}}, {"b", {0, 1}, {7, 8}}}));
  EXPECT_EQ(figure["numbers"].size(), 3U);
  EXPECT_EQ(figure["panels"][0]["curves"][0]["x"], figure["panels"][0]["curves"][1]["x"]);
}

TEST(FigureJson, SmallDifferencesOfLargeNumbersAreKept) {
  // A view of 4e-3 around 1e6: ten significant digits would leave steps of 1e-4 in it.
  const auto figure = parsed(panel_of({{"", {0, 1}, {1e6 + 1e-3, 1e6 + 3e-3}}}));
  const auto y = column(figure, "y");
  EXPECT_NEAR(y[1].get<double>() - y[0].get<double>(), 2e-3, 1e-6 * 4e-3);
}

TEST(FigureJson, ALongCurveIsThinnedAndKeepsItsPeaks) {
  Curve curve{"", {}, {}};
  for (int i = 0; i < 100000; ++i) {
    curve.x.push_back(i);
    curve.y.push_back(i == 54321 ? 7 : std::sin(i));
  }
  const auto figure = parsed(panel_of({curve}));
  const auto y = column(figure, "y");
  EXPECT_LE(y.size(), 4004U);  // four points on each of 1000 columns and the edge of the last
  EXPECT_GT(y.size(), 3000U);
  EXPECT_NE(std::find(y.begin(), y.end(), json(7)), y.end());
}

TEST(FigureJson, BandsBoxesCirclesMarkersAndLinesAreThere) {
  auto panel =
      panel_of({{"band", {0, 1}, {2, 3}, CurveStyle::band, Colour::blue, {1, 1}},
                {"cells", {0, 1}, {2, NAN}, CurveStyle::boxes, Colour::blue, {1, 1}, {1, 2}}});
  panel.circles = {{0, 0, 1, true, "disk"}};
  panel.markers = {{0.5, 0.5, "here", Colour::black, MarkerShape::ring}};
  panel.lines = {{0.25, true}};
  const auto figure = parsed(panel);
  const auto& curves = figure["panels"][0]["curves"];
  ASSERT_EQ(curves.size(), 3U);
  EXPECT_EQ(curves[0]["style"], "disk");
  for (std::size_t i = 0; i < column(figure, "x").size(); ++i)
    EXPECT_NEAR(
        std::hypot(column(figure, "x")[i].get<double>(), column(figure, "y")[i].get<double>()), 1,
        1e-6);
  EXPECT_EQ(column(figure, "y_low", 1), json({1, 1}));
  EXPECT_EQ(column(figure, "x_high", 2), json::array({1}))
      << "a box that cannot be shown is left out";
  EXPECT_EQ(figure["panels"][0]["markers"][0]["label"], "here");
  EXPECT_EQ(figure["panels"][0]["markers"][0]["shape"], "ring");
  EXPECT_EQ(figure["panels"][0]["lines"][0]["value"], 0.25);
}

TEST(FigureJson, NoTextEndsTheElementThatHoldsIt) {
  const std::string nasty = "</script><img src=x onerror=alert(1)>\xff<!-- & \"";
  auto panel = panel_of({{nasty, {0, 1}, {0, 1}}});
  panel.title = panel.x_axis.label = panel.x_axis.unit = nasty;
  panel.y_axis.names = {nasty};
  panel.markers = {{0.5, 0.5, nasty}};
  const auto text = figure_as_json({nasty, {panel}});
  for (const char mark : {'<', '>', '&'}) EXPECT_EQ(text.find(mark), std::string::npos) << mark;
  EXPECT_EQ(json::parse(text)["panels"][0]["title"],
            "</script><img src=x onerror=alert(1)>?<!-- & \"");
}

TEST(FigureJson, CurvesOfUnequalLengthsAreRefused) {
  EXPECT_THROW(figure_as_json({"", {panel_of({{"", {0, 1}, {0}}})}}), Error);
  EXPECT_THROW(figure_as_json({"", {}}), Error);
}

TEST(WebAssets, AreTheFilesOfTheSourceTree) {
  EXPECT_EQ(figure_script(), read_text("src/gyrator/plots/web/figures.js"));
  EXPECT_EQ(figure_style(), read_text("src/gyrator/plots/web/figures.css"));
}

TEST(WebAssets, TheScriptCanStandInsideItsElement) {
  for (const char* end : {"</script", "]]>", "<!--"})
    EXPECT_EQ(figure_script().find(end), std::string::npos) << end;
}

/// What the page allows to run is what it holds, by the base64 of a SHA-256.
TEST(HtmlPage, AllowsItsOwnScriptAndNoOther) {
  const auto page = html_page("title", "<p>text</p>", PageScript::figures);
  const auto from = page.find("<script>") + 8;
  const auto script = page.substr(from, page.find("</script>", from) - from);
  const auto hex = compute_sha256(script);
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bits;
  for (const char digit : hex)
    for (int bit = 3; bit >= 0; --bit)
      bits += std::stoi(std::string(1, digit), nullptr, 16) >> bit & 1 ? '1' : '0';
  bits += "00";  // 256 bits are 42 letters and four bits more
  std::string base64;
  for (std::size_t at = 0; at < bits.size(); at += 6)
    base64 += letters[std::stoul(bits.substr(at, 6), nullptr, 2)];
  EXPECT_NE(page.find("script-src 'sha256-" + base64 + "='\""), std::string::npos) << base64;
  EXPECT_EQ(html_page("title", "").find("script"), std::string::npos);
}

TEST(InteractiveFigure, HoldsPictureAndDataOfTheSameFigure) {
  const Figure figure{"", {panel_of({{"handle", {0, 1}, {0, 1}}})}};
  const auto html = html_interactive_figure(figure, "run", "How to read <it>");
  EXPECT_NE(html.find("<svg"), std::string::npos);
  EXPECT_NE(html.find(figure_as_json(figure)), std::string::npos);
  EXPECT_NE(html.find("How to read &lt;it&gt;"), std::string::npos);
}

}  // namespace
}  // namespace gyrator
