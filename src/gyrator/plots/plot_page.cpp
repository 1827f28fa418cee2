#include "gyrator/plots/plot_page.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/plots/pretty_text.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace gyrator {
namespace {

// Pixels around a panel's frame.
constexpr int room_left = 84;
constexpr int room_right = 26;
constexpr int room_top = 14;
constexpr int room_top_with_title = 36;
constexpr int room_bottom = 28;
constexpr int room_bottom_with_label = 56;
// Pixels of the key: height of a line, length of the drawn sample, gap between columns.
constexpr int key_line = 20;
constexpr int key_sample = 30;
constexpr int key_gap = 28;
constexpr int title_height = 36;

struct KeyEntry {
  std::string title;
  CurveStyle style = CurveStyle::line;
  Colour colour = Colour::blue;
};

std::vector<KeyEntry> key_entries(const Panel& panel) {
  std::vector<KeyEntry> entries;
  for (const auto& circle : panel.circles)
    if (!circle.title.empty())
      entries.push_back(
          {circle.title, circle.filled ? CurveStyle::area : CurveStyle::line, circle.colour});
  for (const auto& curve : panel.curves)
    if (!curve.title.empty()) entries.push_back({curve.title, curve.style, curve.colour});
  return entries;
}

/// What the names of an axis need more than numbers would.
int room_for_names(const Figure& figure) {
  constexpr int numbers = 40;
  double widest = 0;
  for (const auto& panel : figure.panels) {
    for (const auto& name : panel.y_axis.names) widest = std::max(widest, text_width(name));
  }
  return std::max(0, static_cast<int>(widest) - numbers);
}

int widest_entry(const std::vector<KeyEntry>& entries) {
  double widest = 0;
  for (const auto& entry : entries) widest = std::max(widest, text_width(entry.title));
  return key_sample + 8 + static_cast<int>(widest);
}

/// As many entries side by side as the longest lets fit.
int key_columns(const Panel& panel, int width) {
  const auto entries = key_entries(panel);
  if (entries.empty()) return 0;
  const int fitting = (width + key_gap) / (widest_entry(entries) + key_gap);
  const int columns = std::clamp(fitting, 1, static_cast<int>(entries.size()));
  // Four entries look better as two rows of two than as three and one.
  const int rows = (static_cast<int>(entries.size()) + columns - 1) / columns;
  return (static_cast<int>(entries.size()) + rows - 1) / rows;
}

int key_height(const Panel& panel, int columns) {
  if (columns == 0) return 0;
  const int entries = static_cast<int>(key_entries(panel).size());
  return (entries + columns - 1) / columns * key_line + 10;
}

double across(double x, const Page& page) {
  return x / page.width;
}
double up(double y, const Page& page) {
  return 1.0 - y / page.height;
}

/// The short piece of curve before an entry's text.
std::string key_sample_at(const KeyEntry& entry, double x, double y, const Page& page) {
  const auto* colour = hex(entry.colour);
  if (entry.style == CurveStyle::area || entry.style == CurveStyle::band ||
      entry.style == CurveStyle::boxes)
    return fmt::format(
        "set object rectangle from screen {:.5f},{:.5f} to screen {:.5f},{:.5f} fs transparent "
        "solid {} noborder fc rgb '{}'\n",
        across(x, page), up(y - 5, page), across(x + key_sample, page), up(y + 5, page),
        entry.style == CurveStyle::boxes ? 0.45 : 0.25, colour);
  if (entry.style == CurveStyle::points)
    return fmt::format("set label '' at screen {:.5f},{:.5f} point pt 7 ps 0.6 lc rgb '{}'\n",
                       across(x + 0.5 * key_sample, page), up(y, page), colour);
  const auto* dashes = entry.style == CurveStyle::dashed   ? "dt (8,5)"
                       : entry.style == CurveStyle::dotted ? "dt (2,4)"
                                                           : "dt 1";
  return fmt::format(
      "set arrow from screen {:.5f},{:.5f} to screen {:.5f},{:.5f} nohead lw 2 {} lc rgb '{}'\n",
      across(x, page), up(y, page), across(x + key_sample, page), up(y, page), dashes, colour);
}

}  // namespace

const char* hex(Colour colour) {
  switch (colour) {
    case Colour::blue:
      return "#0072B2";
    case Colour::vermillion:
      return "#D55E00";
    case Colour::green:
      return "#009E73";
    case Colour::orange:
      return "#E69F00";
    case Colour::purple:
      return "#CC79A7";
    case Colour::sky:
      return "#56B4E9";
    case Colour::grey:
      return "#8C8C8C";
    case Colour::black:
      break;
  }
  return "#000000";
}

std::string quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : plain_text(text)) {
    if (c == '\'') quoted += '\'';
    quoted += c;
  }
  return quoted + "'";
}

double text_width(std::string_view text, double pixels) {
  const auto characters = std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
  });
  return 0.53 * pixels * static_cast<double>(characters);
}

std::string text_at(std::string_view text, double x, double y, const char* align,
                    const std::string& look, const Page& page) {
  return fmt::format("set label {} at screen {:.5f},{:.5f} {} noenhanced front {}\n", quoted(text),
                     across(x, page), up(y, page), align, look);
}

std::string font(double pixels, const Page& page) {
  return fmt::format("font ',{:.4g}'", pixels * page.points_per_pixel);
}

Page lay_out(const Figure& figure, double points_per_pixel) {
  if (figure.panels.empty())
    throw Error(ErrorCode::bad_input, "figure", "\"" + figure.title + "\" has no panels");
  const int count = static_cast<int>(figure.panels.size());
  const int columns = std::clamp(figure.columns, 1, count);
  Page page{
      columns * figure.panel_width, figure.title.empty() ? 0 : title_height, {}, points_per_pixel};
  const int more = room_for_names(figure);
  for (int first = 0; first < count; first += columns) {
    int key = 0;  // the highest key of the row
    for (int i = first; i < std::min(first + columns, count); ++i) {
      const auto& panel = figure.panels[static_cast<std::size_t>(i)];
      const int left = (i - first) * figure.panel_width;
      const int bottom = page.height + figure.panel_height;
      PanelPlace place;
      place.left = left + room_left + more;
      place.right = left + figure.panel_width - room_right;
      place.top = page.height + (panel.title.empty() ? room_top : room_top_with_title);
      place.bottom = bottom - (panel.x_axis.label.empty() ? room_bottom : room_bottom_with_label);
      place.key_top = bottom;
      place.key_columns = key_columns(panel, place.width());
      key = std::max(key, key_height(panel, place.key_columns));
      page.places.push_back(place);
    }
    page.height += figure.panel_height + key;
  }
  page.height += 4;
  return page;
}

std::string frame_settings(const PanelPlace& place, const Page& page) {
  return fmt::format(
      "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\n"
      "set tmargin at screen {:.5f}\nset bmargin at screen {:.5f}\n",
      across(place.left, page), across(place.right, page), up(place.top, page),
      up(place.bottom, page));
}

std::string panel_title(const Panel& panel, const PanelPlace& place, const Page& page) {
  if (panel.title.empty()) return {};
  // A long title gets smaller letters rather than running into its neighbour.
  const double room = place.width() + 0.5 * room_left;
  const double size = std::clamp(14 * room / text_width(panel.title, 14), 9.0, 14.0);
  return text_at(panel.title, 0.5 * (place.left + place.right), place.top - 16, "center",
                 font(size, page), page);
}

std::string page_title(const Figure& figure, const Page& page) {
  if (figure.title.empty()) return {};
  const double size = std::clamp(17.0 * page.width / text_width(figure.title, 17), 9.0, 17.0);
  return text_at(figure.title, 0.5 * page.width, 20, "center", font(size, page), page);
}

std::string key_settings(const Panel& panel, const PanelPlace& place, const Page& page) {
  const auto entries = key_entries(panel);
  if (entries.empty()) return {};
  const int step = widest_entry(entries) + key_gap;
  const double middle = 0.5 * (place.left + place.right);
  const double left = middle - 0.5 * (place.key_columns * step - key_gap);
  std::string settings;
  int index = 0;
  for (const auto& entry : entries) {
    const int row = index / place.key_columns;
    const int column = index % place.key_columns;
    const double x = left + column * step;
    const double y = place.key_top + 10 + row * key_line;
    settings += key_sample_at(entry, x, y, page);
    settings += text_at(entry.title, x + key_sample + 8, y, "left", "tc rgb '#000000'", page);
    ++index;
  }
  return settings;
}

}  // namespace gyrator
