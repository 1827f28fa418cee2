#pragma once

#include "gyrator/plots/plot.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// A panel's place on the page in pixels from the top left corner: the frame of its axes and,
/// below the axis labels, where no data can be, its key.
struct PanelPlace {
  int left = 0;
  int right = 0;
  int top = 0;
  int bottom = 0;
  int key_top = 0;
  int key_columns = 0;  ///< 0 without a key

  int width() const { return right - left; }
  int height() const { return bottom - top; }
};

/// The whole picture: its size in pixels and its panels' places, worked out here rather than by
/// gnuplot, so that axes line up and no key is cut.
struct Page {
  int width = 0;
  int height = 0;
  std::vector<PanelPlace> places;
  double points_per_pixel = 1;  ///< of the terminal's font sizes
};

/// Throws bad_input for a figure without panels.
Page lay_out(const Figure& figure, double points_per_pixel);

/// "#RRGGBB".
const char* hex(Colour colour);

/// `text` as a gnuplot string. In single quotes gnuplot knows one special character, the quote
/// itself, written twice: no markup and no command can be in it.
std::string quoted(std::string_view text);

/// gnuplot's settings for a panel's frame and for its own title and key, drawn as labels.
std::string frame_settings(const PanelPlace& place, const Page& page);
std::string panel_title(const Panel& panel, const PanelPlace& place, const Page& page);
std::string key_settings(const Panel& panel, const PanelPlace& place, const Page& page);
std::string page_title(const Figure& figure, const Page& page);

/// gnuplot's label of `text` beginning at (centred on) a pixel of the page; `look` is a font or a
/// text colour.
std::string text_at(std::string_view text, double x, double y, const char* align,
                    const std::string& look, const Page& page);

/// Width of text in pixels; only near enough for spacing.
double text_width(std::string_view text, double pixels = 13);

/// "font ',9.75'" for a size in pixels.
std::string font(double pixels, const Page& page);

constexpr double text_pixels = 13;  ///< the size of ordinary text

}  // namespace gyrator
