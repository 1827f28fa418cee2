#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace gyrator {
namespace {

using nlohmann::json;

// Halfway to the neighbours on either side.
std::pair<double, double> cell_edges(const std::vector<double>& centres, std::size_t i) {
  if (centres.size() == 1) {
    const double half = centres[0] != 0 ? std::abs(centres[0]) / 2 : 0.5;
    return {centres[0] - half, centres[0] + half};
  }
  const double before = i > 0 ? (centres[i] - centres[i - 1]) / 2 : 0;
  const double after = i + 1 < centres.size() ? (centres[i + 1] - centres[i]) / 2 : 0;
  return {centres[i] - (i > 0 ? before : after), centres[i] + (after > 0 ? after : before)};
}

}  // namespace

std::vector<Curve> time_map_cells(const json& boundary) {
  const std::string place = "zwidth result: /boundaries/map";
  const auto damping = required_numbers(boundary, "damping", place);
  const json& map = required(boundary, "map", place);
  const auto stiffness = required_numbers(map, "stiffness", place);
  const json& rows = required_array(map, "outcome", place);
  constexpr std::array<std::pair<const char*, Colour>, 3> classes{std::pair{"settles", Colour::sky},
                                                                  {"limit cycle", Colour::orange},
                                                                  {"diverges", Colour::vermillion}};
  std::vector<Curve> curves;
  for (const auto& [title, colour] : classes)
    curves.push_back({title, {}, {}, CurveStyle::boxes, colour});
  for (std::size_t j = 0; j < damping.size(); ++j) {
    auto [left, right] = cell_edges(damping, j);
    // A little over the next column, which is drawn later: no seams.
    if (j + 1 < damping.size()) right += 0.03 * (right - left);
    // Cells of one class above one another are one box.
    for (std::size_t i = 0; i < std::min(stiffness.size(), rows.size());) {
      const int outcome = rows[i].at(j).get<int>();
      std::size_t last = i;
      while (last + 1 < stiffness.size() && rows[last + 1].at(j).get<int>() == outcome) ++last;
      Curve& curve = curves.at(static_cast<std::size_t>(std::clamp(outcome, 0, 2)));
      curve.x.push_back(left);
      curve.x_high.push_back(right);
      // The first row reaches down to the axis.
      curve.y_low.push_back(i == 0 ? 0 : cell_edges(stiffness, i).first);
      curve.y.push_back(cell_edges(stiffness, last).second);
      i = last + 1;
    }
  }
  std::erase_if(curves, [](const Curve& curve) { return curve.x.empty(); });
  return curves;
}

}  // namespace gyrator
