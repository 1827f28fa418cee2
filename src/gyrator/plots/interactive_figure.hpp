#pragma once

#include "gyrator/plots/plot.hpp"

#include <string>

namespace gyrator {

/// The figure with its caption for an html_page with PageScript::figures: the picture of
/// figure_as_svg, which stays in print and where no script runs, and the data from which the
/// page's script makes an interactive plot in its place. Ids and errors as for figure_as_svg.
std::string html_interactive_figure(const Figure& figure, const std::string& id,
                                    const std::string& caption);

}  // namespace gyrator
