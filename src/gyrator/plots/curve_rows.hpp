#pragma once

#include "gyrator/plots/plot.hpp"
#include "gyrator/plots/plot_axes.hpp"

#include <cstddef>
#include <vector>

namespace gyrator {

/// A point of a curve as it is drawn, in data units.
struct Row {
  bool shown = true;  ///< false: the line breaks here
  double x = 0;
  double y = 0;
  double y_low = 0;  ///< for a band; y otherwise
};

/// The curve's points in their order; not shown where a value is no number or the axis cannot show
/// it. Not for boxes.
std::vector<Row> rows_of(const Curve& curve, const PanelView& view);

/// The corners of a polygon that looks round in `view`, the last being the first again: finer
/// where the view is a close-up of the rim.
std::vector<Row> rows_of(const Circle& circle, const PanelView& view);

/// Which of the curve's boxes the axes can show.
std::vector<std::size_t> boxes_shown(const Curve& curve, const PanelView& view);

/// Where there are more than `allowed` rows: of neighbours that fall on the same of `columns`
/// across the view, the first, lowest, highest and last. Drawn on as many pixels, the picture is
/// the same, and its file does not grow with the run.
std::vector<Row> thinned(const std::vector<Row>& rows, const PanelView& view, int columns,
                         std::size_t allowed);

/// Throws bad_input, naming panel and curve, where the curve's columns are not equally long.
void check_lengths(const Panel& panel, const Curve& curve);

}  // namespace gyrator
