#include "gyrator/plots/svg_canvas.hpp"

#include "gyrator/plots/schematic_symbols.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

TEST(SvgCanvas, TextIsMeasuredNoNarrowerThanTheWidestCommonFontSetsIt) {
  // Advance widths of Verdana (of DejaVu Sans where it is wider) in thousandths of the size.
  struct Width {
    const char* text;
    double thousandths;
  };
  for (const auto& [text, thousandths] : {Width{"0123456789", 6364},
                                          {"W", 989},
                                          {"M", 863},
                                          {"m", 974},
                                          {"w", 818},
                                          {"%", 1076},
                                          {"+", 838},
                                          {"-", 454},
                                          {".", 364},
                                          {"/", 454},
                                          {"f", 352},
                                          {"j", 344},
                                          {"r", 427},
                                          {"t", 394},
                                          {"I", 421},
                                          {"Q", 787},
                                          {"_", 636},
                                          {"{", 636},
                                          {"~", 838},
                                          {"@", 1000},
                                          {"\"", 460},
                                          {"Ω", 817},
                                          {"µ", 642},
                                          {"·", 364},
                                          {"²", 542},
                                          {"⁻", 528}})
    EXPECT_GE(measure_text(text), 13 * thousandths / 1000) << text;
}

TEST(SvgCanvas, ASubscriptsMarkTakesNoRoom) {
  EXPECT_EQ(measure_text("R_m", Letters::name), measure_text("Rm"));
  SvgCanvas canvas;
  canvas.draw_text({0, 0}, "e = K_t v", Align::left, Letters::name);
  const auto svg = canvas.finish(100, 100, "", "");
  EXPECT_NE(svg.find(">e = K<tspan dy=\"3\" font-size=\"9.75\">t</tspan><tspan dy=\"-3\"> "
                     "</tspan>v</text>"),
            std::string::npos)
      << svg;
}

TEST(SvgCanvas, EveryTextIsEscapedAndOrdinaryTextHasNoSubscripts) {
  SvgCanvas canvas;
  canvas.begin_group("<g>");
  canvas.draw_text({0, 0}, "<b>_&", Align::left);
  canvas.draw_text({0, 0}, "<R_<>", Align::left, Letters::name);
  canvas.end_group();
  const auto svg = canvas.finish(100, 100, "a<b", "c&d");
  for (const char* part : {"<title>&lt;g&gt;</title>", ">&lt;b&gt;_&amp;</text>", ">&lt;R<tspan",
                           ">&lt;&gt;</tspan>", "<title>a&lt;b</title>", "<desc>c&amp;d</desc>"})
    EXPECT_NE(svg.find(part), std::string::npos) << part << "\n" << svg;
}

TEST(SvgCanvas, ATextThatDoesNotFitEndsInAnEllipsisBetweenCharacters) {
  EXPECT_EQ(fit_text("short", 100), "short");
  const auto shown = fit_text("ΩΩΩΩΩΩΩΩΩΩ", measure_text("ΩΩΩ…") + 1);
  EXPECT_EQ(shown, "ΩΩΩ…");
  EXPECT_LE(measure_text(fit_text(std::string(500, 'x'), 90)), 90);
}

TEST(SvgCanvas, AnArrowEndsAtItsTip) {
  SvgCanvas canvas;
  canvas.draw_arrow({{0, 0}, {0, 20}}, Ink::signal);
  double lowest = 0;
  for (const Stroke& stroke : canvas.strokes()) lowest = std::max(lowest, stroke.to.y);
  EXPECT_EQ(lowest, 20);
}

TEST(Symbols, StayWithinTheirSizeAndReachBothEnds) {
  for (int i = 0; i <= static_cast<int>(Symbol::box); ++i) {
    const auto symbol = static_cast<Symbol>(i);
    SvgCanvas canvas;
    draw_symbol(canvas, symbol, {0, -50}, {0, 50}, Ink::wire, "A");
    double top = 0;
    double bottom = 0;
    double widest = 0;
    for (const Stroke& stroke : canvas.strokes()) {
      for (const Point& p : {stroke.from, stroke.to}) {
        top = std::min(top, p.y);
        bottom = std::max(bottom, p.y);
        widest = std::max(widest, std::abs(p.x));
      }
    }
    EXPECT_LE(widest, size_of(symbol).half_width + 1e-9) << i;
    EXPECT_EQ(top, -50) << i;
    EXPECT_EQ(bottom, symbol == Symbol::mass ? size_of(symbol).half_length : 50) << i;
  }
}

}  // namespace
}  // namespace gyrator
