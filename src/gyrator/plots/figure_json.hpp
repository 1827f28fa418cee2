#pragma once

#include "gyrator/plots/plot.hpp"

#include <string>

namespace gyrator {

/// The figure as JSON for the page's script (web/src): panels with axes, curves, markers and lines,
/// and the numbers, each list once, to which the curves refer by its place.
///
///   {"columns": 1, "panel_width": 560, "panel_height": 360, "numbers": [[0, 1, …], …],
///    "panels": [{"title", "equal_aspect", "x": axis, "y": axis, "curves": [{"title", "style",
///    "colour", "x": 0, "y": 1, "y_low", "x_high"}, …], "markers": […], "lines": […]}, …]}
///   axis: {"label", "name", "unit", "logarithmic", "low", "high", "exponent", "names"}
///
/// Values are in data units, with enough digits to tell points apart in a view a 10⁵th of the
/// axis; a value that cannot be shown is null. A curve of more than 4000 points is thinned as
/// `thinned` does on 1000 columns. Circles come first among the curves, as polygons of style
/// "disk" or "circle". The characters <, > and & are escaped: nothing in it ends the element that
/// holds it. Errors as for figure_as_svg.
std::string figure_as_json(const Figure& figure);

}  // namespace gyrator
