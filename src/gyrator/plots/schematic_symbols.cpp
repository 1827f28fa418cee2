#include "gyrator/plots/schematic_symbols.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gyrator {
namespace {

// A symbol's own axes: u runs from the middle towards `b`, v across, to the left of that way.
class Frame {
 public:
  Frame(SvgCanvas& canvas, Point a, Point b, Ink ink)
      : canvas_(canvas), ink_(ink), middle_{(a.x + b.x) / 2, (a.y + b.y) / 2} {
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    along_ = {(b.x - a.x) / length, (b.y - a.y) / length};
    half_ = length / 2;
  }

  Point at(double u, double v) const {
    return {middle_.x + u * along_.x + v * along_.y, middle_.y + u * along_.y - v * along_.x};
  }
  double half() const { return half_; }

  void line(const std::vector<Point>& points) const { canvas_.draw_line(placed(points), ink_); }
  void shape(const std::vector<Point>& points, bool filled = false) const {
    canvas_.draw_shape(placed(points), ink_, filled);
  }
  void box(double u, double v, double half_length, double half_width, bool filled = false) const {
    shape({{u - half_length, v - half_width},
           {u + half_length, v - half_width},
           {u + half_length, v + half_width},
           {u - half_length, v + half_width}},
          filled);
  }
  void circle(double radius) const { canvas_.draw_circle(middle_, radius, ink_); }
  void letter(std::string_view text) const { canvas_.draw_text(middle_, text, Align::middle); }
  // The wires, up to `from` before and after `to` behind the middle.
  void wires(double from, double to) const {
    line({{-half_, 0}, {from, 0}});
    line({{to, 0}, {half_, 0}});
  }
  // + on a's side; the bar of - lies across, whichever way the symbol stands.
  void signs(double u) const {
    constexpr double arm = 4;
    line({{-u - arm, 0}, {-u + arm, 0}});
    line({{-u, -arm}, {-u, arm}});
    line({{u, -arm}, {u, arm}});
  }

 private:
  std::vector<Point> placed(const std::vector<Point>& points) const {
    std::vector<Point> result;
    for (const Point& p : points) result.push_back(at(p.x, p.y));
    return result;
  }

  SvgCanvas& canvas_;
  Ink ink_;
  Point middle_;
  Point along_;
  double half_ = 0;
};

std::vector<Point> make_arc(Point centre, double radius, double from, double to) {
  constexpr int pieces = 10;
  std::vector<Point> points;
  for (int i = 0; i <= pieces; ++i) {
    const double angle = from + (to - from) * i / pieces;
    points.push_back({centre.x + radius * std::cos(angle), centre.y + radius * std::sin(angle)});
  }
  return points;
}

void draw_inductor(const Frame& frame) {
  constexpr double radius = 5.5;
  std::vector<Point> turns;
  for (int turn = 0; turn < 4; ++turn) {
    const auto arc = make_arc({radius * (2 * turn - 3), 0}, radius, std::numbers::pi, 0);
    turns.insert(turns.end(), arc.begin(), arc.end());
  }
  frame.wires(-4 * radius, 4 * radius);
  frame.line(turns);
}

void draw_clamp(const Frame& frame) {
  frame.wires(-16, 16);
  frame.shape({{-16, -9}, {-16, 9}, {0, 0}});
  frame.shape({{16, -9}, {16, 9}, {0, 0}});
  frame.line({{-3, -9}, {0, -9}, {0, 9}, {3, 9}});
}

void draw_spring(const Frame& frame) {
  std::vector<Point> zigzag{{-24, 0}};
  for (int i = 0; i < 6; ++i) zigzag.push_back({-20 + 8.0 * i, i % 2 == 0 ? 8.0 : -8.0});
  zigzag.push_back({24, 0});
  frame.wires(-24, 24);
  frame.line(zigzag);
}

void draw_damper(const Frame& frame) {
  frame.line({{-frame.half(), 0}, {-2, 0}});
  frame.line({{-2, -8}, {-2, 8}});
  frame.line({{-14, -11}, {14, -11}, {14, 11}, {-14, 11}});
  frame.line({{14, 0}, {frame.half(), 0}});
}

// A disk edge-on between two pole pieces or shoes, `gap` away from it.
void draw_disk_brake(const Frame& frame, double gap) {
  constexpr double shoe = 5;
  frame.wires(-6, 6);
  frame.box(0, 0, 18, 2.5, true);
  frame.box(0, 2.5 + gap + shoe, 9, shoe);
  frame.box(0, -2.5 - gap - shoe, 9, shoe);
}

}  // namespace

SymbolSize size_of(Symbol symbol) {
  switch (symbol) {
    case Symbol::capacitor:
      return {4, 14};
    case Symbol::current_source:
    case Symbol::voltage_source:
    case Symbol::controlled_voltage:
      return {18, 18};
    case Symbol::meter:
      return {12, 12};
    case Symbol::mass:
    case Symbol::brake:
    case Symbol::friction:
      return {18, 18};
    case Symbol::box:
      return {24, 16};
    default:
      return {24, 12};
  }
}

void draw_symbol(SvgCanvas& canvas, Symbol symbol, Point a, Point b, Ink ink,
                 std::string_view letter) {
  const Frame frame(canvas, a, b, ink);
  const auto [half_length, half_width] = size_of(symbol);
  switch (symbol) {
    case Symbol::resistor:
      frame.wires(-20, 20);
      return frame.box(0, 0, 20, 7);
    case Symbol::capacitor:
      frame.wires(-half_length, half_length);
      frame.line({{-half_length, -half_width}, {-half_length, half_width}});
      return frame.line({{half_length, -half_width}, {half_length, half_width}});
    case Symbol::inductor:
      return draw_inductor(frame);
    case Symbol::clamp:
      return draw_clamp(frame);
    case Symbol::current_source:
      frame.wires(-half_length, half_length);
      frame.circle(half_length);
      return canvas.draw_arrow({frame.at(11, 0), frame.at(-11, 0)}, ink);
    case Symbol::voltage_source:
      frame.wires(-half_length, half_length);
      frame.circle(half_length);
      return frame.signs(9);
    case Symbol::controlled_voltage:
      frame.wires(-half_length, half_length);
      frame.shape({{-half_length, 0}, {0, half_width}, {half_length, 0}, {0, -half_width}});
      return frame.signs(8);
    case Symbol::meter:
      frame.wires(-half_length, half_length);
      frame.circle(half_length);
      return frame.letter(letter);
    case Symbol::spring:
      return draw_spring(frame);
    case Symbol::damper:
      return draw_damper(frame);
    case Symbol::brake:
      return draw_disk_brake(frame, 4);
    case Symbol::friction:
      return draw_disk_brake(frame, 0);
    case Symbol::mass:
      frame.line({{-frame.half(), 0}, {-half_length, 0}});
      return frame.box(0, 0, half_length, half_width);
    case Symbol::box:
      frame.wires(-half_length, half_length);
      return frame.box(0, 0, half_length, half_width);
  }
}

void draw_ground(SvgCanvas& canvas, Point at) {
  canvas.draw_line({at, {at.x, at.y + 8}}, Ink::wire);
  for (int bar = 0; bar < 3; ++bar) {
    const double half = 11 - 4.0 * bar;
    const double y = at.y + 8 + 4.0 * bar;
    canvas.draw_line({{at.x - half, y}, {at.x + half, y}}, Ink::wire);
  }
}

void draw_fixed_frame(SvgCanvas& canvas, Point at) {
  canvas.draw_line({{at.x - 14, at.y}, {at.x + 14, at.y}}, Ink::shaft);
  for (int i = 0; i < 5; ++i) {
    const double x = at.x - 9 + 5.5 * i;
    canvas.draw_line({{x, at.y}, {x - 6, at.y + 7}}, Ink::wire);
  }
}

void draw_junction(SvgCanvas& canvas, Point at, Ink ink) {
  canvas.draw_circle(at, 2.5, ink, true);
}

void draw_terminal(SvgCanvas& canvas, Point at, Ink ink) {
  canvas.draw_circle(at, 4, ink);
}

void draw_gyrator(SvgCanvas& canvas, Point top_left, Point bottom_right) {
  canvas.draw_box(top_left, bottom_right, Ink::wire);
  constexpr double radius = 16;
  constexpr double quarter = std::numbers::pi / 2;
  const double middle = (top_left.x + bottom_right.x) / 2;
  const double y = top_left.y + 44;
  canvas.draw_line(make_arc({middle - radius - 4, y}, radius, -quarter, quarter), Ink::wire);
  canvas.draw_line(make_arc({middle + radius + 4, y}, radius, quarter, 3 * quarter), Ink::wire);
}

void draw_sum(SvgCanvas& canvas, Point at) {
  canvas.draw_circle(at, sum_radius, Ink::signal);
  canvas.draw_line({{at.x - 4, at.y}, {at.x + 4, at.y}}, Ink::signal);
  canvas.draw_line({{at.x, at.y - 4}, {at.x, at.y + 4}}, Ink::signal);
}

double block_width(const std::vector<std::string>& lines) {
  double widest = 0;
  for (const auto& line : lines) widest = std::max(widest, measure_text(line, Letters::name));
  return widest + 20;
}

double block_height(const std::vector<std::string>& lines) {
  return line_height * static_cast<double>(lines.size()) + 12;
}

void draw_block(SvgCanvas& canvas, Point centre, const std::vector<std::string>& lines) {
  const double half_width = block_width(lines) / 2;
  const double half_height = block_height(lines) / 2;
  canvas.draw_box({centre.x - half_width, centre.y - half_height},
                  {centre.x + half_width, centre.y + half_height}, Ink::signal);
  canvas.draw_lines(centre, lines, Align::middle, Letters::name);
}

void draw_sampler(SvgCanvas& canvas, Point right, Point left) {
  canvas.draw_circle({right.x - 6, right.y}, 2.5, Ink::signal, true);
  canvas.draw_circle({left.x + 6, left.y}, 2.5, Ink::signal, true);
  canvas.draw_line({right, {right.x - 6, right.y}, {left.x + 10, left.y - 13}}, Ink::signal);
  canvas.draw_line({{left.x + 6, left.y}, left}, Ink::signal);
}

}  // namespace gyrator
