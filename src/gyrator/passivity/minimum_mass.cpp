#include "gyrator/passivity/minimum_mass.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/aliased_disk.hpp"
#include "gyrator/passivity/frequency_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>

namespace gyrator {
namespace {

constexpr double search_range = 1e6;      // either way from K_c T^2 + B_c T
constexpr double search_accuracy = 1e-5;  // of the mass

class MassSearch {
 public:
  MassSearch(const PassivityModel& model, VirtualCoupling coupling)
      : coupling_(std::move(coupling)),
        period_(model.sampling.period.to_double()),
        output_(make_output_law(model.controller)),
        disk_(model.device, model.sampling),
        grid_(make_judging_grid(disk_.model().poles(), period_)),
        plant_(sample_plant(build_plant(build_device_network(model.device, FreeOperator{})),
                            model.sampling)) {
    for (const double omega : grid_) points_.push_back(disk_.at(omega));
  }

  std::optional<double> find() {
    const SpringDamper& c = coupling_.coupling;
    const double scale = period_ * (c.stiffness * period_ + c.damping);
    if (scale == 0) return 0;
    double low = scale * search_range;
    if (!holds(low)) return std::nullopt;
    double high = low;
    while (holds(low)) {
      high = low;
      low /= 2;
      if (low < scale / search_range) return 0;
    }
    while (high - low > search_accuracy * high) {
      const double middle = std::sqrt(low * high);
      (holds(middle) ? high : low) = middle;
    }
    return high;
  }

 private:
  bool holds(double mass) {
    coupling_.tool_inertia = mass;
    if (!holds_for(in_series(make_coupling_law(coupling_, period_), output_))) return false;
    if (!coupling_.wall) return true;
    VirtualCoupling free = coupling_;
    free.wall.reset();
    return holds_for(in_series(make_coupling_law(free, period_), output_));
  }

  bool holds_for(const DiscreteStateSpace& law) {
    if (compute_spectral_radius(build_loop_matrix(plant_, law)) > 1 + stability_tolerance)
      return false;
    const auto margin = [&](const DiskPoint& point) {
      return point.damping_margin(law.response(std::polar(1.0, point.omega * period_)));
    };
    std::vector<double> values;
    for (const DiskPoint& point : points_) {
      values.push_back(margin(point));
      if (!(values.back() > 0)) return false;
    }
    // The grid knows the device's resonances; the tool on its coupling has its own.
    const double nyquist = std::numbers::pi / period_;
    for (const auto& pole : law.A.eigenvalues()) {
      const double centre = std::abs(std::arg(pole)) / period_;
      const double width = std::max(std::abs(1 - std::abs(pole)) / period_, 1e-6 * centre);
      for (int i = -8; i <= 8; ++i) {
        const double omega = centre + i * width / 4;
        if (omega < grid_.front() || omega > nyquist) continue;
        if (!(margin(disk_.at(omega)) > 0)) return false;
      }
    }
    return find_minimum(grid_, values, [&](double omega) {
             return margin(disk_.at(omega));
           }).value > 0;
  }

  VirtualCoupling coupling_;
  double period_;
  DiscreteStateSpace output_;  // of the linear wrappers
  AliasedDisk disk_;
  std::vector<double> grid_;
  std::vector<DiskPoint> points_;
  SampledPlant plant_;
};

}  // namespace

std::optional<double> find_minimum_mass(const PassivityModel& model, Integration integration) {
  const auto* coupling = std::get_if<VirtualCoupling>(&model.controller.law);
  if (!coupling) {
    throw Error(ErrorCode::bad_input, "controller/kind",
                "no simulated tool whose mass could be varied: use \"virtual_coupling\"");
  }
  VirtualCoupling varied = *coupling;
  varied.integration = integration;
  return MassSearch(model, std::move(varied)).find();
}

}  // namespace gyrator
