#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// A place on the canvas in pixels; y grows downwards.
struct Point {
  double x = 0;
  double y = 0;
};

/// What a stroke stands for; each has its own colour and width, dark enough to print.
enum class Ink {
  wire,    ///< conductors, electrical symbols
  shaft,   ///< what moves: a thicker line
  signal,  ///< commands and measurements, which carry no power
  frame    ///< dashed, around what belongs together
};

enum class Align { left, middle, right };

enum class Letters {
  name,   ///< "R_m": what follows '_' is set as subscript, up to the next blank
  plain,  ///< as it is
  title   ///< as it is, larger and bold
};

/// Where a text lies, measured generously, so that it holds in whatever font is at hand.
struct TextBox {
  double left = 0, top = 0, right = 0, bottom = 0;
  std::string text;
};

/// A straight piece of something drawn.
struct Stroke {
  Point from, to;
};

/// Width of a text in pixels, not less than in the widest of the common sans-serif fonts.
double measure_text(std::string_view text, Letters letters = Letters::plain);

/// The text, or as much of it as fits into `width` pixels, with an ellipsis.
std::string fit_text(std::string_view text, double width, Letters letters = Letters::plain);

/// Distance from one line of text to the next, and how far letters reach from their middle line.
inline constexpr double line_height = 17;
inline constexpr double letter_reach = 8;

/// A drawing in SVG that keeps account of itself: every text's box and every stroke can be asked
/// for, so that a test can tell whether anything overlaps. No fonts or files are loaded, no script,
/// no identifiers: it can be put into a page as it is. The background is white, also on a dark
/// page.
class SvgCanvas {
 public:
  /// A line through the points; arcs are given as many of them.
  void draw_line(const std::vector<Point>& points, Ink ink);
  /// The same, closed; filled with the ink, or with white.
  void draw_shape(const std::vector<Point>& corners, Ink ink, bool filled = false);
  void draw_box(Point corner, Point opposite, Ink ink);
  void draw_circle(Point centre, double radius, Ink ink, bool filled = false);
  /// A line that ends in an arrowhead.
  void draw_arrow(std::vector<Point> points, Ink ink);
  /// Text whose letters' middle lies at `at`. Any characters: they are escaped.
  void draw_text(Point at, std::string_view text, Align align, Letters letters = Letters::plain);
  /// Several lines, their middle at `at`.
  void draw_lines(Point at, const std::vector<std::string>& lines, Align align,
                  Letters first_letters = Letters::plain);

  /// What is drawn until end_group is one thing, and this is its name for a reader and the mouse.
  void begin_group(std::string_view title);
  void end_group();

  const std::vector<TextBox>& texts() const { return texts_; }
  const std::vector<Stroke>& strokes() const { return strokes_; }

  /// The whole file; `title` and `description` for who cannot see it.
  std::string finish(double width, double height, std::string_view title,
                     std::string_view description) const;

 private:
  void add_path(const std::vector<Point>& points, Ink ink, bool closed, bool filled);

  std::string body_;
  std::vector<TextBox> texts_;
  std::vector<Stroke> strokes_;
};

}  // namespace gyrator
