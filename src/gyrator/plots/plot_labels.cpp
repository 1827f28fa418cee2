#include "gyrator/plots/plot_labels.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace gyrator {
namespace {

constexpr double cell = 4;  // pixels
constexpr double text_height = 16;

struct Box {
  double left = 0;
  double right = 0;
  double top = 0;
  double bottom = 0;
};

/// The panel's frame in cells, each counting what is drawn there.
class Crowd {
 public:
  explicit Crowd(const PanelPlace& place)
      : place_(place),
        columns_(static_cast<int>(place.width() / cell) + 1),
        rows_(static_cast<int>(place.height() / cell) + 1),
        cells_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0) {}

  void add_line(double x0, double y0, double x1, double y1) {
    const double length = std::hypot(x1 - x0, y1 - y0);
    // Beyond a few frames' length the line is outside anyway.
    const int steps = static_cast<int>(std::min(length / cell * 2, 5000.0)) + 1;
    for (int i = 0; i <= steps; ++i) {
      const double part = static_cast<double>(i) / steps;
      const double x = x0 + part * (x1 - x0);
      const double y = y0 + part * (y1 - y0);
      add({x, x, y, y}, 1);
    }
  }

  void add(const Box& box, int amount) {
    visit(box, [&](int& count) { count += amount; });
  }

  /// What the box would cover; what sticks out of the frame counts much.
  double cost(const Box& box) {
    double sum = 0;
    visit(box, [&](const int& count) { sum += count; });
    const double outside = std::max({place_.left - box.left, box.right - place_.right,
                                     place_.top - box.top, box.bottom - place_.bottom, 0.0});
    return sum + 20 * outside;
  }

 private:
  template <typename Visit>
  void visit(const Box& box, const Visit& visit_cell) {
    const auto index = [](double pixels, int count) {
      return static_cast<int>(std::clamp(std::floor(pixels / cell), -1.0, count * 1.0));
    };
    const int first_row = std::max(0, index(box.top - place_.top, rows_));
    const int last_row = std::min(rows_ - 1, index(box.bottom - place_.top, rows_));
    const int first = std::max(0, index(box.left - place_.left, columns_));
    const int last = std::min(columns_ - 1, index(box.right - place_.left, columns_));
    for (int row = first_row; row <= last_row; ++row)
      for (int column = first; column <= last; ++column)
        visit_cell(cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                          static_cast<std::size_t>(column)]);
  }

  const PanelPlace& place_;
  int columns_;
  int rows_;
  std::vector<int> cells_;
};

struct Pixel {
  double x = 0;
  double y = 0;
};

Pixel pixel_of(double x, double y, const PanelView& view, const PanelPlace& place) {
  return {place.left + view.x.fraction(x) * place.width(),
          place.bottom - view.y.fraction(y) * place.height()};
}

void add_curves(Crowd& crowd, const Panel& panel, const PanelView& view, const PanelPlace& place) {
  for (const auto& curve : panel.curves) {
    if (curve.style == CurveStyle::band || curve.style == CurveStyle::area ||
        curve.style == CurveStyle::boxes)
      continue;  // light
    for (std::size_t i = 1; i < std::min(curve.x.size(), curve.y.size()); ++i) {
      if (!view.x.can_show(curve.x[i - 1]) || !view.y.can_show(curve.y[i - 1]) ||
          !view.x.can_show(curve.x[i]) || !view.y.can_show(curve.y[i]))
        continue;
      const auto from = pixel_of(curve.x[i - 1], curve.y[i - 1], view, place);
      const auto to = pixel_of(curve.x[i], curve.y[i], view, place);
      crowd.add_line(from.x, from.y, to.x, to.y);
    }
  }
  for (const auto& circle : panel.circles)
    for (int i = 0; i < 720; ++i) {
      const double angle = i * 0.5 * std::acos(-1.0) / 180;
      const auto at = pixel_of(circle.centre_x + circle.radius * std::cos(angle),
                               circle.centre_y + circle.radius * std::sin(angle), view, place);
      crowd.add({at.x, at.x, at.y, at.y}, 1);
    }
  for (const auto& line : panel.lines) {
    if (!(line.vertical ? view.x : view.y).can_show(line.value)) continue;
    const auto at = line.vertical ? pixel_of(line.value, view.y.low, view, place)
                                  : pixel_of(view.x.low, line.value, view, place);
    if (line.vertical) {
      crowd.add_line(at.x, place.top, at.x, place.bottom);
    } else {
      crowd.add_line(place.left, at.y, place.right, at.y);
    }
  }
}

struct Candidate {
  Box box;
  double detour = 0;  ///< what its distance from the marker costs
};

/// Places beside a marker, the reader's habit first: right of it, then around it, then farther.
std::vector<Candidate> places_beside(Pixel at, double width) {
  std::vector<Candidate> candidates;
  for (const double distance : {9.0, 14.0, 20.0, 28.0, 40.0}) {
    const auto add = [&](double x, double y) {
      const Box box{x - 0.5 * width, x + 0.5 * width, y - 0.5 * text_height, y + 0.5 * text_height};
      candidates.push_back({box, 0.4 * distance});
    };
    const double beside = 0.5 * width + distance;
    const double above = 0.5 * text_height + distance - 4;
    add(at.x + beside, at.y);
    add(at.x - beside, at.y);
    // Above or below, anywhere between its left and its right end over the marker.
    for (const double side : {-1.0, 1.0}) {
      add(at.x + beside - 6, at.y + side * (above - 2));
      add(at.x - beside + 6, at.y + side * (above - 2));
      for (const double part : {0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75})
        add(at.x + part * 0.5 * width, at.y + side * above);
    }
  }
  return candidates;
}

/// The first of the best; taken, so that no other text comes there.
LabelSpot take_best(Crowd& crowd, const std::vector<Candidate>& candidates) {
  Box best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (const auto& candidate : candidates) {
    const double cost = crowd.cost(candidate.box) + candidate.detour;
    if (cost >= best_cost) continue;
    best = candidate.box;
    best_cost = cost;
  }
  crowd.add(best, 2);
  return {best.left, 0.5 * (best.top + best.bottom)};
}

}  // namespace

std::vector<LabelSpot> place_labels(const Panel& panel, const PanelView& view,
                                    const PanelPlace& place) {
  Crowd crowd(place);
  add_curves(crowd, panel, view, place);
  const auto shown = [&](const Marker& marker) {
    return view.x.can_show(marker.x) && view.y.can_show(marker.y);
  };
  for (const auto& marker : panel.markers) {
    if (!shown(marker)) continue;
    const auto at = pixel_of(marker.x, marker.y, view, place);
    crowd.add({at.x - 5, at.x + 5, at.y - 5, at.y + 5}, 3);
  }

  std::vector<LabelSpot> spots;
  for (const auto& marker : panel.markers) {
    const bool empty = marker.label.empty() || !shown(marker);
    spots.push_back(empty
                        ? LabelSpot{}
                        : take_best(crowd, places_beside(pixel_of(marker.x, marker.y, view, place),
                                                         text_width(marker.label))));
  }
  return spots;
}

}  // namespace gyrator
