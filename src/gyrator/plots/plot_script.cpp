#include "gyrator/plots/plot_script.hpp"

#include "gyrator/plots/curve_rows.hpp"
#include "gyrator/plots/plot_axes.hpp"
#include "gyrator/plots/plot_labels.hpp"
#include "gyrator/plots/plot_page.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

namespace gyrator {
namespace {

constexpr std::size_t thin_above = 2000;  // points; a shorter curve is drawn as it is

/// The key is drawn apart; in an SVG the name becomes the curve's tool tip.
std::string named(const std::string& title) {
  return title.empty() ? "notitle" : "title " + quoted(title);
}

// ---- Data -------------------------------------------------------------------------------------

/// The rows as a gnuplot datablock; an empty line breaks the line. Empty where nothing is shown.
std::string datablock(const std::vector<Row>& rows, const PanelView& view) {
  std::string block;
  bool broken = true;  // so that no block begins with a break, and two breaks are one
  for (const auto& row : rows) {
    if (row.shown) {
      fmt::format_to(std::back_inserter(block), "{:.8g} {:.8g} {:.8g}\n", view.x.scaled(row.x),
                     view.y.scaled(row.y), view.y.scaled(row.y_low));
    } else if (!broken) {
      block += '\n';
    }
    broken = !row.shown;
  }
  return block;
}

// ---- What is drawn ----------------------------------------------------------------------------

/// The drawing in the making: data first, then settings, then one plot command.
struct Drawing {
  std::string data;
  std::string settings;
  std::vector<std::string> plots;
  int blocks = 0;
  const Page& page;

  std::string add_data(const std::string& block) {
    std::string name = fmt::format("$data{}", ++blocks);
    data += fmt::format("{} << END_OF_DATA\n{}END_OF_DATA\n", name, block);
    return name;
  }
};

std::string style_of(const Curve& curve, const AxisView& y) {
  const auto* colour = hex(curve.colour);
  switch (curve.style) {
    case CurveStyle::line:
      return fmt::format("using 1:2 with lines lw 2 lc rgb '{}'", colour);
    case CurveStyle::dashed:
      return fmt::format("using 1:2 with lines lw 2 dt (8,5) lc rgb '{}'", colour);
    case CurveStyle::dotted:
      return fmt::format("using 1:2 with lines lw 2 dt (2,4) lc rgb '{}'", colour);
    case CurveStyle::steps:
      return fmt::format("using 1:2 with steps lw 1.5 lc rgb '{}'", colour);
    case CurveStyle::points:
      return fmt::format("using 1:2 with points pt 7 ps 0.5 lc rgb '{}'", colour);
    case CurveStyle::impulses:
      return fmt::format("using 1:2 with impulses lw 2 lc rgb '{}'", colour);
    case CurveStyle::area:
      return fmt::format(
          "using 1:2 with filledcurves y={} fs transparent solid 0.18 noborder fc rgb '{}'",
          y.logarithmic ? y.low : 0.0, colour);
    case CurveStyle::band:
    case CurveStyle::boxes:  // add_boxes()
      break;
  }
  return fmt::format("using 1:2:3 with filledcurves fs transparent solid 0.18 noborder fc rgb '{}'",
                     colour);
}

// Opaque, so that lines on top can be told from it; without edges, that neighbours are one area.
void add_boxes(Drawing& drawing, const Curve& curve, const PanelView& view) {
  std::string block;
  for (const auto i : boxes_shown(curve, view)) {
    const double low_x = view.x.scaled(curve.x[i]), high_x = view.x.scaled(curve.x_high[i]);
    const double low_y = view.y.scaled(curve.y_low[i]), high_y = view.y.scaled(curve.y[i]);
    fmt::format_to(std::back_inserter(block), "{:.8g} {:.8g} {:.8g} {:.8g} {:.8g} {:.8g}\n",
                   (low_x + high_x) / 2, (low_y + high_y) / 2, low_x, high_x, low_y, high_y);
  }
  if (block.empty()) return;
  drawing.plots.push_back(
      fmt::format("{} using 1:2:3:4:5:6 with boxxyerror fs solid 0.45 noborder fc rgb '{}' {}",
                  drawing.add_data(block), hex(curve.colour), named(curve.title)));
}

void add_curve(Drawing& drawing, const Curve& curve, const PanelView& view, int columns) {
  if (curve.style == CurveStyle::boxes) return add_boxes(drawing, curve, view);
  auto rows = rows_of(curve, view);
  if (curve.style != CurveStyle::band) rows = thinned(rows, view, columns, thin_above);
  const auto block = datablock(rows, view);
  if (block.empty()) return;
  drawing.plots.push_back(fmt::format("{} {} {}", drawing.add_data(block), style_of(curve, view.y),
                                      named(curve.title)));
}

void add_circle(Drawing& drawing, const Circle& circle, const PanelView& view) {
  const auto block = datablock(rows_of(circle, view), view);
  if (block.empty()) return;
  const auto name = drawing.add_data(block);
  if (circle.filled)
    drawing.plots.push_back(
        fmt::format("{} using 1:2 with filledcurves closed fs transparent solid 0.18 noborder fc "
                    "rgb '{}' notitle",
                    name, hex(circle.colour)));
  drawing.plots.push_back(fmt::format("{} using 1:2 with lines lw 2 lc rgb '{}' {}", name,
                                      hex(circle.colour), named(circle.title)));
}

void add_marker(Drawing& drawing, const Marker& marker, LabelSpot spot, const PanelView& view) {
  if (!view.x.can_show(marker.x) || !view.y.can_show(marker.y)) return;
  const char* shape = marker.shape == MarkerShape::dot     ? "pt 7 ps 1.1 lw 1"
                      : marker.shape == MarkerShape::cross ? "pt 2 ps 1.5 lw 3"
                                                           : "pt 6 ps 1.3 lw 2.5";
  const auto name = drawing.add_data(
      fmt::format("{:.8g} {:.8g}\n", view.x.scaled(marker.x), view.y.scaled(marker.y)));
  drawing.plots.push_back(fmt::format("{} using 1:2 with points {} lc rgb '{}' notitle", name,
                                      shape, hex(marker.colour)));
  if (!marker.label.empty())
    drawing.settings += text_at(marker.label, spot.left, spot.middle, "left",
                                fmt::format("tc rgb '{}'", hex(marker.colour)), drawing.page);
}

void add_reference(Drawing& drawing, const ReferenceLine& line, const PanelView& view) {
  const AxisView& axis = line.vertical ? view.x : view.y;
  if (!axis.can_show(line.value)) return;
  const double fraction = axis.fraction(line.value);
  if (fraction < 0 || fraction > 1) return;
  const double at = axis.scaled(line.value);
  const auto ends = line.vertical
                        ? fmt::format("{0:.8g}, graph 0 to {0:.8g}, graph 1", at)
                        : fmt::format("graph 0, first {0:.8g} to graph 1, first {0:.8g}", at);
  drawing.settings += fmt::format("set arrow from {} nohead lw 1 lc rgb '#777777' back\n", ends);
}

// ---- Panels and page --------------------------------------------------------------------------

std::string axis_settings(char name, const AxisView& view) {
  std::string text = fmt::format("set {}range [{:.8g}:{:.8g}]\nset {}label {} noenhanced{}\n", name,
                                 view.scaled(view.low), view.scaled(view.high), name,
                                 quoted(view.label), name == 'x' ? " offset 0,0.5" : "");
  if (!view.names.empty()) {
    std::vector<std::string> ticks;
    for (std::size_t i = 0; i < view.names.size(); ++i)
      ticks.push_back(fmt::format("{} {}", quoted(view.names[i]), i + 1));
    return text + fmt::format("set {}tics ({}) noenhanced\n", name, fmt::join(ticks, ", "));
  }
  if (view.logarithmic)
    text += fmt::format("set logscale {0} 10\nset format {0} '10^{{%L}}'\nset m{0}tics 10\n", name);
  return text;
}

std::string panel_script(const Panel& panel, const PanelPlace& place, const Page& page,
                         int& blocks) {
  for (const auto& curve : panel.curves) check_lengths(panel, curve);
  const auto view = view_of(panel, place.width(), place.height());
  Drawing drawing{{}, {}, {}, blocks, page};
  for (const auto& circle : panel.circles) add_circle(drawing, circle, view);
  for (const auto& curve : panel.curves) add_curve(drawing, curve, view, place.width());
  for (const auto& line : panel.lines) add_reference(drawing, line, view);
  const auto spots = place_labels(panel, view, place);
  for (std::size_t i = 0; i < panel.markers.size(); ++i)
    add_marker(drawing, panel.markers[i], spots[i], view);
  blocks = drawing.blocks;

  std::string script = drawing.data;
  script +=
      "unset logscale\nset format '%g'\nunset mxtics\nunset mytics\n"
      "set xtics autofreq\nset ytics autofreq\n";
  script += frame_settings(place, page) + axis_settings('x', view.x) + axis_settings('y', view.y);
  script += panel_title(panel, place, page) + key_settings(panel, place, page) + drawing.settings;
  // Drawing NaN last draws at least the axes where there is no data.
  drawing.plots.emplace_back("NaN notitle");
  script += fmt::format("plot {}\n", fmt::join(drawing.plots, ", \\\n     "));
  return script + "unset label\nunset arrow\nunset object\n";
}

/// gnuplot's PNG sizes fonts in points at 96 dpi, its SVG in pixels.
double points_per_pixel(PlotFormat format) {
  return format == PlotFormat::png ? 0.75 : 1.0;
}

std::string terminal(PlotFormat format, const Page& page, const std::string& svg_name) {
  const double size = text_pixels * page.points_per_pixel;
  if (format == PlotFormat::png)
    return fmt::format(
        "set terminal pngcairo enhanced rounded size {},{} font 'DejaVu Sans,{:.4g}' fontscale 2 "
        "linewidth 2 pointscale 2 background rgb 'white'\n",
        2 * page.width, 2 * page.height, size);
  return fmt::format(
      "set terminal svg enhanced rounded {} size {},{} font 'DejaVu Sans,Verdana,Arial,"
      "sans-serif,{:.4g}' name '{}' background rgb 'white'\n",
      format == PlotFormat::svg_file ? "fixed" : "dynamic", page.width, page.height, size,
      svg_name);
}

}  // namespace

std::string gnuplot_script(const Figure& figure, PlotFormat format, const std::string& svg_name) {
  const auto page = lay_out(figure, points_per_pixel(format));
  std::string script = "set encoding utf8\n" + terminal(format, page, svg_name);
  script +=
      "set border 3 lw 1 lc rgb '#444444'\n"
      "set tics nomirror out scale 0.6,0.3 tc rgb '#222222'\n"
      "set grid xtics ytics lw 0.8 lt 1 lc rgb '#E4E4E4' back\n"
      "unset key\nset multiplot\n";
  script += page_title(figure, page);
  int blocks = 0;
  for (std::size_t i = 0; i < figure.panels.size(); ++i)
    script += panel_script(figure.panels[i], page.places[i], page, blocks);
  return script + "unset multiplot\n";
}

}  // namespace gyrator
