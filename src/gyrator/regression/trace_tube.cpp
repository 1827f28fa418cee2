#include "gyrator/regression/trace_tube.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace gyrator {
namespace {

using Column = std::vector<double>;

constexpr double thinning_share = 0.1;
constexpr double rounding = 1e-12;  // of a time, relative

/// A straight line over an interval [a, b].
struct Line {
  double at_a = 0, at_b = 0;
};

// What y over t does between a + shift and b + shift, where it has no corner in between. Looked up
// in the middle: at its ends the interval may touch a jump, on this side of it or on that.
Line find_line(const Column& t, const Column& y, double a, double b, double shift) {
  const auto next = std::upper_bound(t.begin(), t.end(), a + (b - a) / 2 + shift);
  if (next == t.begin()) return {y.front(), y.front()};
  if (next == t.end()) return {y.back(), y.back()};
  const auto i = static_cast<std::size_t>(next - t.begin());
  const double slope = (y[i] - y[i - 1]) / (t[i] - t[i - 1]);
  return {y[i - 1] + slope * (a + shift - t[i - 1]), y[i - 1] + slope * (b + shift - t[i - 1])};
}

// What the tube's edge follows within an interval in which no row enters or leaves the window: the
// window's two ends and the outermost of the rows inside.
struct Edge {
  std::array<Line, 3> lines{};

  double largest(double share) const {
    double value = lines[0].at_a + share * (lines[0].at_b - lines[0].at_a);
    for (const Line& line : lines)
      value = std::max(value, line.at_a + share * (line.at_b - line.at_a));
    return value;
  }
};

// The upper edge of a tube, max r over the window; for the lower one all columns are mirrored.
class Tube {
 public:
  Tube(const Column& trace_t, const Column& trace_y, const Column& t, const Column& y, double dt)
      : trace_t_(trace_t), trace_y_(trace_y), t_(t), y_(y), dt_(dt) {}

  void search(double sign, double dy, std::optional<TubeExit>& exit) const {
    const Column corners = list_corners();
    for (std::size_t i = 0; i + 1 < corners.size(); ++i)
      search_interval(corners[i], corners[i + 1], sign, dy, exit);
    // No interval has a jump's rows at the first and the last instant, nor a trace of one row.
    for (std::size_t i = 0; i < trace_t_.size(); ++i) {
      const double limit = find_largest_at(trace_t_[i]) + dy;
      if (!(trace_y_[i] - limit <= 0)) note(trace_t_[i], sign * trace_y_[i], sign * limit, exit);
    }
  }

 private:
  // Between two of these neither trace nor edge has a corner, but for lines that cross.
  Column list_corners() const {
    Column corners = trace_t_;
    for (const double t : t_) {
      corners.push_back(t - dt_);
      corners.push_back(t + dt_);
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    const auto is_outside = [&](double t) { return t < trace_t_.front() || t > trace_t_.back(); };
    corners.erase(std::remove_if(corners.begin(), corners.end(), is_outside), corners.end());
    return corners;
  }

  Edge find_edge(double a, double b) const {
    const Line first = find_line(t_, y_, a, b, -dt_);
    Edge edge{{first, find_line(t_, y_, a, b, dt_), first}};
    // Rows that are inside the window all the way from a to b.
    const double middle = a + (b - a) / 2;
    const auto begin = std::upper_bound(t_.begin(), t_.end(), middle - dt_) - t_.begin();
    const auto end = std::lower_bound(t_.begin(), t_.end(), middle + dt_) - t_.begin();
    if (begin < end) {
      const double most = *std::max_element(y_.begin() + begin, y_.begin() + end);
      edge.lines[2] = {most, most};
    }
    return edge;
  }

  // Of the window around an instant, its ends included.
  double find_largest_at(double time) const {
    double most =
        std::max(find_line(t_, y_, time, time, -dt_).at_a, find_line(t_, y_, time, time, dt_).at_a);
    const double slack = rounding * std::abs(time);
    const auto begin = std::lower_bound(t_.begin(), t_.end(), time - dt_ - slack) - t_.begin();
    const auto end = std::upper_bound(t_.begin(), t_.end(), time + dt_ + slack) - t_.begin();
    if (begin < end) most = std::max(most, *std::max_element(y_.begin() + begin, y_.begin() + end));
    return most;
  }

  void search_interval(double a, double b, double sign, double dy,
                       std::optional<TubeExit>& exit) const {
    const Edge edge = find_edge(a, b);
    const Line trace = find_line(trace_t_, trace_y_, a, b, 0);
    std::vector<double> shares{0, 1};
    for (std::size_t i = 0; i < edge.lines.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double at_a = edge.lines[i].at_a - edge.lines[j].at_a;
        const double at_b = edge.lines[i].at_b - edge.lines[j].at_b;
        if (at_a * at_b < 0) shares.push_back(at_a / (at_a - at_b));
      }
    }
    std::sort(shares.begin(), shares.end());
    for (const double share : shares) {
      const double value = trace.at_a + share * (trace.at_b - trace.at_a);
      const double limit = edge.largest(share) + dy;
      if (value - limit <= 0) continue;  // what is no number is told elsewhere
      note(a + share * (b - a), sign * value, sign * limit, exit);
    }
  }

  static void note(double time, double value, double limit, std::optional<TubeExit>& exit) {
    const double outside = std::abs(value - limit);
    const double largest = exit ? std::max(exit->outside, outside) : outside;
    if (!exit || time < exit->time_s) exit = TubeExit{0, time, value, limit, 0};
    exit->outside = largest;
  }

  const Column& trace_t_;
  const Column& trace_y_;
  const Column& t_;
  const Column& y_;
  double dt_;
};

Column mirror(Column y, double sign) {
  for (double& value : y) value *= sign;
  return y;
}

bool is_elsewhere(double time, double expected, double dt) {
  return std::abs(time - expected) > dt + rounding * std::abs(expected);
}

// A trace that starts late, stops early, or goes on, is no motion like the reference.
std::optional<TubeExit> find_other_end(const TraceTable& trace, const TraceTable& reference,
                                       double dt) {
  const double start = trace.time_s.front();
  const double first = reference.time_s.front();
  if (is_elsewhere(start, first, dt))
    return TubeExit{0, start, start, first, std::abs(start - first), true, false};
  const double end = trace.time_s.back();
  const double last = reference.time_s.back();
  if (is_elsewhere(end, last, dt))
    return TubeExit{0, end, end, last, std::abs(end - last), false, true};
  return std::nullopt;
}

}  // namespace

double compute_tube_width(const TubeColumn& column, const Column& reference) {
  const auto [low, high] = std::minmax_element(reference.begin(), reference.end());
  return column.absolute + column.relative * (*high - *low);
}

std::optional<TubeExit> find_tube_exit(const TraceTable& trace, const TraceTable& reference,
                                       const TraceExpectation& tube) {
  std::optional<TubeExit> first;
  for (std::size_t c = 0; c < tube.columns.size(); ++c) {
    std::optional<TubeExit> exit;
    const double dy = compute_tube_width(tube.columns[c], reference.columns[c]);
    for (const double sign : {1.0, -1.0}) {
      const Column value = mirror(trace.columns[c], sign);
      const Column limit = mirror(reference.columns[c], sign);
      Tube(trace.time_s, value, reference.time_s, limit, tube.time_s).search(sign, dy, exit);
    }
    if (!exit) continue;
    exit->column = c;
    if (!first || exit->time_s < first->time_s) first = exit;
  }
  return first ? first : find_other_end(trace, reference, tube.time_s);
}

TraceTable thin_trace(const TraceTable& trace, const TraceExpectation& tube) {
  std::vector<double> allowed;
  for (std::size_t c = 0; c < tube.columns.size(); ++c)
    allowed.push_back(thinning_share * compute_tube_width(tube.columns[c], trace.columns[c]));
  const Column& t = trace.time_s;
  // Whether one line from row i to row k passes near enough by all rows between.
  const auto is_straight = [&](std::size_t i, std::size_t k) {
    if (t[k] == t[i]) return k == i + 1;
    for (std::size_t c = 0; c < allowed.size(); ++c) {
      const Column& y = trace.columns[c];
      for (std::size_t j = i + 1; j < k; ++j) {
        if (t[j] == t[j - 1] || t[j + 1] == t[j]) return false;  // a jump
        const double line = y[i] + (y[k] - y[i]) * (t[j] - t[i]) / (t[k] - t[i]);
        if (!(std::abs(line - y[j]) <= allowed[c])) return false;
      }
    }
    return true;
  };
  std::vector<std::size_t> kept{0};
  constexpr std::size_t longest = 1000;  // rows that one line replaces, so that this ends soon
  for (std::size_t k = 1; k < t.size(); ++k) {
    const std::size_t i = kept.back();
    if (k + 1 < t.size() && k + 1 - i <= longest && is_straight(i, k + 1)) continue;
    kept.push_back(k);
  }
  TraceTable thin;
  thin.columns.resize(trace.columns.size());
  for (const std::size_t k : kept) {
    thin.time_s.push_back(t[k]);
    for (std::size_t c = 0; c < trace.columns.size(); ++c)
      thin.columns[c].push_back(trace.columns[c][k]);
  }
  return thin;
}

}  // namespace gyrator
