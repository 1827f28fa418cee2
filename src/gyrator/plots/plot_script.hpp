#pragma once

#include "gyrator/plots/plot.hpp"

#include <string>

namespace gyrator {

enum class PlotFormat { svg_file, svg_embedded, png };

/// The gnuplot program that draws `figure`, data included, to standard output.
///
/// Ranges, breaks at values that are no numbers, thinning of long curves to what the picture can
/// show, and powers of ten on the axes are worked out here, so that gnuplot only draws. Text of
/// the figure stands in single quotes with markup off: neither markup nor command can be in it.
/// Throws bad_input for unequal lengths and for a figure without panels. `svg_name` as for
/// figure_as_svg.
std::string gnuplot_script(const Figure& figure, PlotFormat format, const std::string& svg_name);

}  // namespace gyrator
