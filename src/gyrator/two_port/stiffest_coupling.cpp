#include "gyrator/two_port/stiffest_coupling.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/passivity/frequency_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <boost/math/tools/minima.hpp>
#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int points_over_damping = 60;
constexpr double decades_of_damping = 6;
constexpr double stiffness_accuracy = 1e-5;
constexpr double stiffness_range = 1e6;  // either way from 2 b/T

}  // namespace

StiffestCoupling::StiffestCoupling(const Device& device, const ComputedPath& path)
    : device_(device), path_(path), grid_(make_two_port_grid(device_.poles(), path.period)) {
  for (const double omega : grid_) needs_.push_back(need_at(omega));
}

StiffestCoupling::Need StiffestCoupling::need_at(double omega) const {
  const SampledPort port = compute_sampled_port(device_, path_, omega);
  const double damping = port.impedance.real();
  if (!(damping > 0)) return {omega, infinity};
  // |p| + Re p, without cancellation.
  const LlewellynMargins asked =
      compute_llewellyn_margins({damping, port.actuation, -port.sensing, 0.0});
  return {omega, std::max(0.0, -asked.third / (2 * damping) - port.feedback.real())};
}

double StiffestCoupling::bound_at(const Need& need, double damping) const {
  const double R = need.compliance;
  const double c = damping;
  if (!(R * c <= 1)) return -1;  // not even a damper alone
  const double sign = path_.integration == Integration::explicit_euler ? -1 : 1;
  const double q = 1 / std::tan(need.omega * path_.step / 2);
  if (R == 0) return sign > 0 ? infinity : 2 * c / path_.step;
  const double a = R * (1 + q * q);
  const double b = sign * (2 * R * c - 1);
  const double root = std::sqrt(b * b + 4 * a * c * (1 - R * c));
  // The upper root, by the form that does not cancel.
  const double x = b <= 0 ? (root - b) / (2 * a) : 2 * c * (1 - R * c) / (root + b);
  return 2 * x / path_.step;
}

CouplingLimit StiffestCoupling::find(double damping) const {
  if (!(damping >= 0)) {
    throw Error(ErrorCode::bad_input, "damping",
                fmt::format("{:g}: a coupling's must be at least 0", damping));
  }
  std::vector<double> bounds;
  bounds.reserve(needs_.size());
  for (const Need& need : needs_) bounds.push_back(bound_at(need, damping));
  const Minimum least =
      find_minimum(grid_, bounds, [&](double omega) { return bound_at(need_at(omega), damping); });
  const double hertz = least.omega > grid_.front() ? least.omega / (2 * std::numbers::pi) : 0;
  if (least.value < 0) return {false, 0, hertz};
  return {true, least.value, hertz};
}

std::optional<BestCoupling> StiffestCoupling::find_best() const {
  double most_asked = 0;
  for (const Need& need : needs_) most_asked = std::max(most_asked, need.compliance);
  if (most_asked == infinity) return std::nullopt;
  if (most_asked == 0) return BestCoupling{0, {true, infinity, 0}};
  // Dampings from a millionth of the largest to itself; the limit over them has one peak.
  const auto damping_at = [&](double share) {
    return std::pow(10.0, decades_of_damping * (share - 1)) / most_asked;
  };
  const auto loss = [&](double share) { return -find(damping_at(share)).stiffness; };
  int best = 0;
  std::vector<double> losses;
  for (int i = 0; i <= points_over_damping; ++i) {
    losses.push_back(loss(static_cast<double>(i) / points_over_damping));
    if (losses.back() < losses[static_cast<std::size_t>(best)]) best = i;
  }
  std::uintmax_t iterations = 60;
  const double low = std::max(0, best - 1) / static_cast<double>(points_over_damping);
  const double high =
      std::min(points_over_damping, best + 1) / static_cast<double>(points_over_damping);
  const auto [share, value] =
      boost::math::tools::brent_find_minima(loss, low, high, 24, iterations);
  double damping = damping_at(share);
  if (losses[static_cast<std::size_t>(best)] < value)
    damping = damping_at(static_cast<double>(best) / points_over_damping);
  BestCoupling found{damping, find(damping)};
  if (const CouplingLimit undamped = find(0); undamped.stiffness > found.limit.stiffness)
    found = {0, undamped};
  return found;
}

std::optional<double> find_stiffest_proxy_coupling(const Device& device,
                                                   const RenderedScene& scene) {
  if (!scene.tool) return std::nullopt;
  RenderingPort port(device, scene);
  const std::vector<double> grid = port.make_grid();
  const double damping = port.device().at(grid.front()).impedance.real();
  const double scale = 2 * std::abs(damping) / scene.path.period;
  RenderedScene varied = scene;
  const auto holds = [&](double stiffness) {
    varied.tool->coupling.stiffness = stiffness;
    port = RenderingPort(device, varied);
    return port.judge(Rendering::proxy).absolutely_stable;
  };
  double low = scale / stiffness_range;
  if (!(scale > 0) || !holds(low)) return 0;
  double high = low;
  constexpr double stride = 1.5;
  do {
    low = high;
    high *= stride;
    if (high > scale * stiffness_range) return std::nullopt;
  } while (holds(high));
  while (high - low > stiffness_accuracy * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace gyrator
