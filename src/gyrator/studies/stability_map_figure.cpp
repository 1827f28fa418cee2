#include "gyrator/core/error.hpp"
#include "gyrator/studies/result_fields.hpp"
#include "gyrator/studies/result_figures.hpp"

#include <algorithm>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;
using Numbers = std::vector<double>;

// Every point of one region.
Curve region_points(const json& result, const char* region, const char* title, Colour colour) {
  const std::string place = "stability-map result";
  const auto beta = required_numbers(result, "beta", place);
  const auto sigma = required_numbers(result, "sigma", place);
  const json& rows = required_array(result, "region", place);
  Curve curve{title, {}, {}, CurveStyle::points, colour};
  for (std::size_t i = 0; i < std::min(sigma.size(), rows.size()); ++i) {
    if (!rows[i].is_array())
      throw Error(ErrorCode::bad_input, place + ": /region", "must be an array of arrays");
    for (std::size_t j = 0; j < std::min(beta.size(), rows[i].size()); ++j) {
      if (rows[i][j] != region) continue;
      curve.x.push_back(beta[j]);
      curve.y.push_back(sigma[i]);
    }
  }
  return curve;
}

}  // namespace

Figure stability_map_figure(const json& result) {
  const std::string place = "stability-map result";
  const auto beta = required_numbers(result, "beta", place);
  const auto sigma = required_numbers(result, "sigma", place);
  if (beta.empty() || sigma.empty()) return {};
  const double enough = 0.5 + required_number(result, "delay_in_periods", place);
  const double velocity = required_number(result, "large_velocity", place);
  const double top = *std::max_element(sigma.begin(), sigma.end());
  const double right = *std::max_element(beta.begin(), beta.end());
  Panel panel{"", {"β = b/(K T)", ""}, {"σ = f_c/(K Δ)", ""}};
  for (auto& curve :
       {region_points(result, "passive", "comes to rest", Colour::blue),
        region_points(result, "locally_stable", "rests after a small kick only", Colour::sky),
        region_points(result, "limit_cycle", "limit cycle", Colour::orange),
        region_points(result, "unstable", "unstable", Colour::vermillion)}) {
    if (!curve.x.empty()) panel.curves.push_back(curve);
  }
  panel.curves.push_back({"passive to the upper right",
                          {enough, enough},
                          {0.5, top},
                          CurveStyle::line,
                          Colour::black});
  panel.curves.push_back({"", {enough, right}, {0.5, 0.5}, CurveStyle::line, Colour::black});
  // sigma = 1/2 + xi'_max (beta_0 - beta), as far as it lies in the picture.
  const double left = std::max(0.0, enough - (top - 0.5) / velocity);
  panel.curves.push_back({fmt::format("locally stable above, up to vT/Δ = {:g}", velocity),
                          {left, enough},
                          {0.5 + velocity * (enough - left), 0.5},
                          CurveStyle::dashed,
                          Colour::black});
  // The same balance over a sinusoid, without the half quantum that a worst case loses per sample.
  constexpr double mean_ratio = std::numbers::pi / 4;  // mean of v^2 over that of |v|, per peak
  const double foot = std::max(0.0, enough - top / (mean_ratio * velocity));
  panel.curves.push_back({fmt::format("energy of a sinusoid with vT/Δ = {:g} balanced", velocity),
                          {foot, enough},
                          {mean_ratio * velocity * (enough - foot), 0},
                          CurveStyle::dashed,
                          Colour::grey});
  panel.curves.push_back({"limit cycles to the lower right",
                          {enough, enough},
                          {0, 0.5},
                          CurveStyle::dotted,
                          Colour::black});
  panel.x_axis.min = 0;
  panel.y_axis.min = 0;
  panel.x_axis.max = right * 1.03;  // room for the last points
  panel.y_axis.max = top * 1.03;
  Figure figure{figure_title(result, "Stability of a sampled wall with encoder and dry friction"),
                {panel}};
  figure.panel_width = 860;
  figure.panel_height = 620;
  return figure;
}

}  // namespace gyrator
