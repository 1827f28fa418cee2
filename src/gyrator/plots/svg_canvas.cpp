#include "gyrator/plots/svg_canvas.hpp"

#include "gyrator/plots/html.hpp"
#include "gyrator/plots/pretty_text.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace gyrator {
namespace {

constexpr double text_size = 13;
constexpr double title_size = 17;
constexpr double subscript_scale = 0.75;
constexpr double subscript_drop = 3;
constexpr int circle_corners = 24;

struct Look {
  const char* colour;
  double width;
  const char* dash;
};

Look look_of(Ink ink) {
  switch (ink) {
    case Ink::wire:
      return {"#1c1c1c", 2, ""};
    case Ink::shaft:
      return {"#1c1c1c", 3.2, ""};
    case Ink::signal:
      return {"#00598c", 1.4, ""};
    case Ink::frame:
      return {"#767676", 1.0, " stroke-dasharray=\"6 4\""};
  }
  return {"#1c1c1c", 2, ""};
}

// A tenth of a pixel is finer than any eye; "-0" and ".0" would only make the file differ.
std::string number(double value) {
  return fmt::format("{}", std::round(value * 10) / 10 + 0.0);
}

// Of one character in parts of the font's size: the widest of DejaVu Sans, Verdana, Arial.
double width_of(char32_t c) {
  constexpr std::u32string_view narrow = U" .,:;'|!()[]/\\ijltfrI-·°";
  constexpr std::u32string_view raised = U"²³⁰¹⁴⁵⁶⁷⁸⁹⁻";
  constexpr std::u32string_view wide = U"mwMW@%+=<>~^#&\u2212×→";
  if (narrow.find(c) != std::u32string_view::npos) return 0.46;
  if (wide.find(c) != std::u32string_view::npos) return 1.08;
  if (raised.find(c) != std::u32string_view::npos) return 0.60;
  if (c < 0x80) return c >= 'A' && c <= 'Z' ? 0.80 : 0.66;
  return c < 0x370 || c == U'Ω' || c == U'τ' || c == U'ω' ? 0.85 : 1.1;
}

std::u32string characters_of(std::string_view utf8) {
  std::u32string characters;
  for (const char byte : plain_text(utf8)) {
    const auto bits = static_cast<unsigned char>(byte);
    if ((bits & 0xC0U) == 0x80U) {
      characters.back() = characters.back() << 6U | (bits & 0x3FU);
    } else {
      characters += bits < 0x80U ? bits : bits & (bits >= 0xF0U ? 7U : bits >= 0xE0U ? 15U : 31U);
    }
  }
  return characters;
}

// Subscripts lowered, and the blank after them back on the line.
std::string with_subscripts(std::string_view name) {
  std::string markup;
  for (std::size_t at = 0; at < name.size();) {
    const auto mark = std::min(name.find('_', at), name.size());
    markup += html_escape(name.substr(at, mark - at));
    if (mark == name.size()) break;
    const auto end = std::min(name.find(' ', mark), name.size());
    markup += fmt::format("<tspan dy=\"{}\" font-size=\"{}\">{}</tspan>", subscript_drop,
                          subscript_scale * text_size,
                          html_escape(name.substr(mark + 1, end - mark - 1)));
    if (end < name.size()) markup += fmt::format("<tspan dy=\"-{}\"> </tspan>", subscript_drop);
    at = end + 1;
  }
  return markup;
}

}  // namespace

double measure_text(std::string_view text, Letters letters) {
  double ems = 0;
  for (const char32_t c : characters_of(text))
    if (letters != Letters::name || c != U'_') ems += width_of(c);
  // Whole pixels, so that lines beside the text are sharp.
  return std::ceil(ems * (letters == Letters::title ? 1.15 * title_size : text_size));
}

std::string fit_text(std::string_view text, double width, Letters letters) {
  std::string shown = plain_text(text);
  if (measure_text(shown, letters) <= width) return shown;
  while (!shown.empty() && measure_text(shown + "…", letters) > width) {
    while ((static_cast<unsigned char>(shown.back()) & 0xC0U) == 0x80U) shown.pop_back();
    shown.pop_back();
  }
  return shown + "…";
}

void SvgCanvas::add_path(const std::vector<Point>& points, Ink ink, bool closed, bool filled) {
  const Look look = look_of(ink);
  std::string path;
  for (const Point& p : points)
    path += fmt::format("{}{} {}", path.empty() ? "M" : "L", number(p.x), number(p.y));
  body_ += fmt::format("<path d=\"{}{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{}\"{}/>\n", path,
                       closed ? "Z" : "",
                       filled                        ? look.colour
                       : closed && ink != Ink::frame ? "#ffffff"
                                                     : "none",
                       look.colour, look.width, look.dash);
  for (std::size_t i = 1; i < points.size(); ++i) strokes_.push_back({points[i - 1], points[i]});
  if (closed && !points.empty()) strokes_.push_back({points.back(), points.front()});
}

void SvgCanvas::draw_line(const std::vector<Point>& points, Ink ink) {
  add_path(points, ink, false, false);
}

void SvgCanvas::draw_shape(const std::vector<Point>& corners, Ink ink, bool filled) {
  add_path(corners, ink, true, filled);
}

void SvgCanvas::draw_box(Point corner, Point opposite, Ink ink) {
  draw_shape({corner, {opposite.x, corner.y}, opposite, {corner.x, opposite.y}}, ink);
}

void SvgCanvas::draw_circle(Point centre, double radius, Ink ink, bool filled) {
  const Look look = look_of(ink);
  body_ += fmt::format(
      "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{}\"/>\n",
      number(centre.x), number(centre.y), number(radius), filled ? look.colour : "#ffffff",
      look.colour, look.width);
  const auto corner = [&](int i) {
    const double angle = 2 * std::numbers::pi * i / circle_corners;
    return Point{centre.x + radius * std::cos(angle), centre.y + radius * std::sin(angle)};
  };
  for (int i = 0; i < circle_corners; ++i) strokes_.push_back({corner(i), corner(i + 1)});
}

void SvgCanvas::draw_arrow(std::vector<Point> points, Ink ink) {
  constexpr double length = 9;
  constexpr double half_width = 4;
  const Point tip = points.back();
  const Point before = points[points.size() - 2];
  const double distance = std::hypot(tip.x - before.x, tip.y - before.y);
  const Point along{(tip.x - before.x) / distance, (tip.y - before.y) / distance};
  const Point base{tip.x - length * along.x, tip.y - length * along.y};
  points.back() = base;  // a blunt line end would show beside the tip
  draw_line(points, ink);
  draw_shape({tip,
              {base.x - half_width * along.y, base.y + half_width * along.x},
              {base.x + half_width * along.y, base.y - half_width * along.x}},
             ink, true);
}

void SvgCanvas::draw_text(Point at, std::string_view text, Align align, Letters letters) {
  if (text.empty()) return;
  const bool title = letters == Letters::title;
  const double size = title ? title_size : text_size;
  const double width = measure_text(text, letters);
  const double left = align == Align::left    ? at.x
                      : align == Align::right ? at.x - width
                                              : at.x - width / 2;
  const char* anchor = align == Align::left ? "start" : align == Align::right ? "end" : "middle";
  // Capitals reach 0.73 of the size above the baseline in these fonts: half of that is the middle.
  body_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"{}\" font-size=\"{}\"{}>{}</text>\n",
                       number(at.x), number(at.y + 0.365 * size), anchor, size,
                       title ? " font-weight=\"bold\"" : "",
                       letters == Letters::name ? with_subscripts(text) : html_escape(text));
  const double reach = letter_reach * size / text_size;
  texts_.push_back({left, at.y - reach, left + width, at.y + reach, plain_text(text)});
}

void SvgCanvas::draw_lines(Point at, const std::vector<std::string>& lines, Align align,
                           Letters first_letters) {
  double y = at.y - 0.5 * line_height * (static_cast<double>(lines.size()) - 1);
  for (std::size_t i = 0; i < lines.size(); ++i, y += line_height)
    draw_text({at.x, y}, lines[i], align, i == 0 ? first_letters : Letters::plain);
}

void SvgCanvas::begin_group(std::string_view title) {
  body_ += "<g><title>" + html_escape(title) + "</title>\n";
}

void SvgCanvas::end_group() {
  body_ += "</g>\n";
}

std::string SvgCanvas::finish(double width, double height, std::string_view title,
                              std::string_view description) const {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" style=\"max-width: {0}px\" role=\"img\" font-family=\"'DejaVu "
      "Sans', Verdana, Arial, "
      "sans-serif\" fill=\"#1c1c1c\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n"
      "<title>{2}</title>\n<desc>{3}</desc>\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n{4}</svg>\n",
      number(width), number(height), html_escape(title), html_escape(description), body_);
}

}  // namespace gyrator
