#pragma once

#include "gyrator/plots/plot.hpp"
#include "gyrator/plots/plot_axes.hpp"
#include "gyrator/plots/plot_page.hpp"

#include <vector>

namespace gyrator {

/// Where a marker's text begins: pixels from the page's top left corner, half-way up its letters.
struct LabelSpot {
  double left = 0;
  double middle = 0;
};

/// For each of the panel's markers, the spot beside it at which its text crosses the fewest curves,
/// markers and other texts, inside the frame and near.
std::vector<LabelSpot> place_labels(const Panel& panel, const PanelView& view,
                                    const PanelPlace& place);

}  // namespace gyrator
