#pragma once

#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// The colours that everyone can tell apart (Okabe and Ito 2008), and a grey.
enum class Colour { blue, vermillion, green, orange, purple, sky, black, grey };

enum class CurveStyle {
  line,
  dashed,
  dotted,
  steps,     ///< held until the next point: a sampled command
  points,    ///< no line
  impulses,  ///< a stem from zero
  area,      ///< filled, lightly, between the curve and zero
  band,      ///< filled, lightly, between `y` and `y_low`
  boxes      ///< filled rectangles from `x` to `x_high` and from `y_low` to `y`
};

/// y over x, of equal length. A value that is no number (or ≤ 0 on a logarithmic axis) breaks
/// the line there. A curve with an empty title is not in the key.
struct Curve {
  std::string title;
  std::vector<double> x;
  std::vector<double> y;
  CurveStyle style = CurveStyle::line;
  Colour colour = Colour::blue;
  std::vector<double> y_low = {};   ///< for `band` and `boxes` only
  std::vector<double> x_high = {};  ///< for `boxes` only
};

/// An axis "label [unit]"; where `min` or `max` is missing, it follows from the data.
/// A linear axis of very small or large numbers is shown in powers of ten of its unit.
struct Axis {
  std::string label;
  std::string unit = {};
  bool logarithmic = false;
  std::optional<double> min = {};
  std::optional<double> max = {};
  std::vector<std::string> names = {};  ///< at 1, 2, … instead of numbers
};

/// A circle in data coordinates, for panels with equal aspect.
struct Circle {
  double centre_x = 0;
  double centre_y = 0;
  double radius = 0;
  bool filled = true;
  std::string title = {};
  Colour colour = Colour::blue;
};

enum class MarkerShape { dot, cross, ring };

/// A single point with a text beside it.
struct Marker {
  double x = 0;
  double y = 0;
  std::string label = {};
  Colour colour = Colour::black;
  MarkerShape shape = MarkerShape::dot;
};

/// A thin line right across the panel at one value of x (vertical) or y.
struct ReferenceLine {
  double value = 0;
  bool vertical = false;
};

struct Panel {
  std::string title;
  Axis x_axis;
  Axis y_axis;
  std::vector<Curve> curves = {};
  std::vector<Circle> circles = {};
  std::vector<Marker> markers = {};
  std::vector<ReferenceLine> lines = {};
  bool equal_aspect = false;  ///< one unit of x is as long as one of y
};

/// Panels in rows of `columns`, read like a page.
struct Figure {
  std::string title;
  std::vector<Panel> panels;
  int columns = 1;
  int panel_width = 560;   ///< pixels
  int panel_height = 360;  ///< pixels
};

/// Draws `figure` with gnuplot into an .svg or .png file (by the extension), whole or not at all;
/// nothing else is left behind. No text of the figure is ever taken as markup or as a command.
/// Throws bad_input for another extension, curves of unequal lengths, a figure without panels,
/// or where gnuplot is not installed.
void render_figure(const Figure& figure, const std::string& path);

/// The figure as one <svg> element for an HTML page, without XML prologue. All ids begin with
/// `id`, so that figures with different ones go on one page; letters, digits and '_' only,
/// beginning with a letter. Errors as for render_figure.
std::string figure_as_svg(const Figure& figure, const std::string& id = "figure");

/// Throws bad_input unless `path` ends in .svg or .png: to be called before long work begins.
void check_figure_path(const std::string& path);

}  // namespace gyrator
