#include "gyrator/passivity/stiffness_limit.hpp"

#include "gyrator/controllers/virtual_wall.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/disk_proof.hpp"
#include "gyrator/passivity/held_limit.hpp"
#include "gyrator/passivity/virtual_damping.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <boost/math/tools/roots.hpp>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();

// D |q|^2 of (disk-3) over K for H = p/q: a quadratic again. Its constant term is summed from parts
// of the given size.
struct MarginPolynomial {
  double value = 0, slope = 0, curvature = 0, size = 0;
};

MarginPolynomial expand_margin(const DiskPoint& disk, const MobiusLaw& law) {
  const auto product = [](Complex a, Complex b) { return std::real(a * std::conj(b)); };
  // The gap is infinite where nothing bounds the loop; a law that is zero does not mind.
  const auto gap = [&](double factor) { return factor == 0 ? 0 : factor * disk.scaled_gap; };
  MarginPolynomial d;
  const double centre = 2 * std::real(law.p0 * std::conj(law.q0) * disk.scaled_center);
  d.value = disk.damping * std::norm(law.q0) + centre + gap(std::norm(law.p0));
  d.slope = 2 * disk.damping * product(law.q0, law.q1) +
            2 * std::real((law.p0 * std::conj(law.q1) + law.p1 * std::conj(law.q0)) *
                          disk.scaled_center) +
            gap(2 * product(law.p0, law.p1));
  d.curvature = disk.damping * std::norm(law.q1) +
                2 * std::real(law.p1 * std::conj(law.q1) * disk.scaled_center) +
                gap(std::norm(law.p1));
  d.size = disk.damping * std::norm(law.q0) +
           2 * std::abs(law.p0) * std::abs(law.q0) * std::abs(disk.scaled_center);
  return d;
}

// First K >= 0 at which value + slope K + curvature K^2 falls to zero. `value` below rounding of
// the `size` of what it was summed from is zero.
double first_root(double value, double slope, double curvature, double size) {
  if (!(value > 1e-13 * size)) return 0;
  const double discriminant = slope * slope - 4 * curvature * value;
  if (std::isinf(curvature)) return curvature < 0 ? 0 : infinity;
  if (discriminant < 0) return infinity;
  const double denominator = -slope + std::sqrt(discriminant);
  return denominator > 0 ? 2 * value / denominator : infinity;
}

}  // namespace

const std::vector<CriterionName>& criterion_names() {
  static const std::vector<CriterionName> names{
      {Criterion::spring_damper, "spring_damper",
       "b > K T/2 + |B| for constant damping and an ideal drive [8.4]"},
      {Criterion::frequency_dependent, "frequency_dependent",
       "Re Z + virtual damping > 0 at every frequency, for an ideal drive [8.46]"},
      {Criterion::exact_disk, "exact_disk",
       "every passive hand, with command path, sensor place and delay"},
      {Criterion::coupled, "coupled", "exact loop eigenvalues with the model's operator"},
  };
  return names;
}

std::string_view name_of(Criterion criterion) {
  return criterion_names()[static_cast<std::size_t>(criterion)].name;
}

StiffnessLimits::StiffnessLimits(const Device& device, const Sampling& sampling,
                                 const VelocityEstimator& estimator, const Operator& held_by)
    : StiffnessLimits(device, sampling, VirtualWall{.velocity = estimator}, held_by) {}

StiffnessLimits::StiffnessLimits(const Device& device, const Sampling& sampling,
                                 const Controller& controller, const Operator& held_by,
                                 GridDensity density)
    : device_(device),
      sampling_(sampling),
      period_(sampling.period.to_double()),
      family_(controller, period_),
      position_family_(
          std::holds_alternative<VirtualWall>(controller.law) ? controller : Controller{}, period_),
      operator_(held_by),
      disk_(device, sampling),
      grid_(make_judging_grid(disk_.model().poles(), period_, density)) {}

const std::vector<DiskPoint>& StiffnessLimits::disks() {
  if (disks_.empty()) {
    for (const double omega : grid_) disks_.push_back(disk_.at(omega));
  }
  return disks_;
}

const std::vector<LawFamily::Point>& StiffnessLimits::laws() {
  if (laws_.empty()) {
    for (const double omega : grid_) laws_.push_back(family_.prepare(omega));
  }
  return laws_;
}

const SampledPlant& StiffnessLimits::sampled() {
  if (!sampled_)
    sampled_ = sample_plant(build_plant(build_device_network(device_, operator_)), sampling_);
  return *sampled_;
}

StiffnessLimit StiffnessLimits::find(Criterion criterion, double virtual_damping) {
  // The wall of a held-impedance drive is analog: every criterion comes down to Re Z >= 0.
  if (find_held_impedance(device_)) return find_held_stiffness_limit(device_, virtual_damping);
  switch (criterion) {
    case Criterion::spring_damper:
      return find_spring_damper(virtual_damping);
    case Criterion::frequency_dependent:
      return find_frequency_dependent(virtual_damping);
    case Criterion::exact_disk:
      return find_exact_disk(virtual_damping);
    case Criterion::coupled:
      break;
  }
  return find_coupled(virtual_damping);
}

StiffnessLimit StiffnessLimits::find_spring_damper(double virtual_damping) {
  const double b = disk_.model().at(grid_.front()).impedance.real();
  const double spare = b - std::abs(virtual_damping);
  const double nyquist_hz = 0.5 / period_;
  if (spare < 0 || b <= 0) return {0, false, nyquist_hz};
  return {2 * spare / period_, true, nyquist_hz};
}

template <class Function>
StiffnessLimit StiffnessLimits::find_lowest(const Function& limit_at,
                                            const std::vector<double>& values) {
  const Minimum lowest = find_minimum(grid_, values, limit_at);
  return {lowest.value, lowest.value > 0, lowest.omega / (2 * std::numbers::pi)};
}

StiffnessLimit StiffnessLimits::find_frequency_dependent(double virtual_damping) {
  const double delay = sampling_.delay.to_double();
  const auto limit = [&](const LawFamily::Point& law, double damping) {
    const double omega = law.omega;
    const Complex late = std::polar(1.0, -omega * delay);
    const Complex damper = position_family_.at(law, virtual_damping).at(0);
    const double available = damping + compute_virtual_damping(omega, period_, late * damper);
    return first_root(available, compute_virtual_damping(omega, period_, late), 0,
                      damping + std::abs(virtual_damping));
  };
  if (position_terms_.empty()) {
    for (const double omega : grid_) {
      position_terms_.push_back(
          {position_family_.prepare(omega), disk_.model().at(omega).impedance.real()});
    }
  }
  std::vector<double> values;
  for (const auto& [law, damping] : position_terms_) values.push_back(limit(law, damping));
  return find_lowest(
      [&](double omega) {
        return limit(position_family_.prepare(omega), disk_.model().at(omega).impedance.real());
      },
      values);
}

double StiffnessLimits::find_disk_limit(const DiskPoint& disk, const LawFamily::Point& law,
                                        double virtual_damping) const {
  const MarginPolynomial d = expand_margin(disk, family_.at(law, virtual_damping));
  return first_root(d.value, d.slope, d.curvature, d.size);
}

double StiffnessLimits::find_upper_bound(double virtual_damping) {
  constexpr std::size_t stride = 8;
  if (!family_.has(virtual_damping)) return 0;
  double bound = infinity;
  const auto lower = [&](double omega) {
    const double limit = find_disk_limit(disk_.at(omega), family_.prepare(omega), virtual_damping);
    bound = std::min(bound, limit);
  };
  for (std::size_t i = 0; i < grid_.size(); i += stride) lower(grid_[i]);
  lower(grid_.back());
  return bound;
}

StiffnessLimit StiffnessLimits::find_on_grid(double virtual_damping) {
  if (!family_.has(virtual_damping)) return {0, false, 0};
  std::vector<double> values;
  const auto& points = disks();
  for (std::size_t i = 0; i < points.size(); ++i)
    values.push_back(find_disk_limit(points[i], laws()[i], virtual_damping));
  if (disk_.least_damping().active) {
    return {0, false, disk_.least_damping().omega / (2 * std::numbers::pi)};
  }
  const StiffnessLimit result = find_lowest(
      [&](double omega) {
        return find_disk_limit(disk_.at(omega), family_.prepare(omega), virtual_damping);
      },
      values);
  if (!result.feasible) return result;

  // The disks exclude a pole on the unit circle for every smaller K, so one stable K proves them
  // all.
  const double inside = std::isfinite(result.stiffness) ? result.stiffness / 2 : 1;
  return is_stable(inside, virtual_damping) ? result : StiffnessLimit{0, false, 0};
}

// With nothing attached, and held still: a law with a corner of its own below the grid (a soft wall
// behind a wave line) could hide there.
bool StiffnessLimits::is_stable(double stiffness, double virtual_damping) const {
  const DiscreteStateSpace law = family_.make(stiffness, virtual_damping);
  for (const Operator& extreme : {Operator{FreeOperator{}}, Operator{ClampedOperator{}}}) {
    if (compute_loop_radius(device_, extreme, sampling_, law) > 1 + stability_tolerance)
      return false;
  }
  return true;
}

StiffnessLimit StiffnessLimits::find_exact_disk(double virtual_damping) {
  constexpr double closest = 1e-5, far = 1e-3;  // below the limit, where it is proved
  constexpr int most_proofs = 40;
  StiffnessLimit limit = find_on_grid(virtual_damping);
  double undecided = 0, proved = 1;  // shares below the limit
  double below = closest;
  for (int i = 0; i < most_proofs && limit.feasible && below < 1; ++i) {
    const double inside =
        std::isfinite(limit.stiffness) ? (1 - below) * limit.stiffness : scale_stiffness();
    if (!std::isfinite(inside)) return limit;  // a command that moves nothing
    const DiskProof proof =
        prove_disk(disk_.model(), sampling_, family_.make(inside, virtual_damping));
    if (proof.outcome == ProofOutcome::proved) {
      proved = below;
      if (proved - undecided <= far) {
        if (!is_stable(inside, virtual_damping)) return {0, false, limit.worst_frequency_hz};
        if (below > far) limit.stiffness = inside;
        return limit;
      }
      below = (proved + undecided) / 2;  // as high as it can be decided
      continue;
    }
    if (proof.active) return {0, false, proof.omega / (2 * std::numbers::pi)};
    // What the grid did not meet: down to the bottom of the dip; or lower, where it is too close to
    // call.
    const Minimum dip = find_minimum_near(proof.omega, [&](double omega) {
      return find_disk_limit(disk_.at(omega), family_.prepare(omega), virtual_damping);
    });
    if (dip.value < inside) {
      limit = {dip.value, dip.value > 0, dip.omega / (2 * std::numbers::pi)};
      undecided = 0;
      proved = 1;
      below = closest;
    } else if (!std::isfinite(limit.stiffness)) {
      break;  // what cannot be decided at one stiffness is not at another
    } else {
      undecided = below;
      below = proved < 1 ? (proved + undecided) / 2 : 4 * below;
    }
  }
  if (proved < 1 && is_stable((1 - proved) * limit.stiffness, virtual_damping)) {
    limit.stiffness *= 1 - proved;
    return limit;
  }
  return {0, false, limit.worst_frequency_hz};
}

// Where to look for a limit: the stiffness at which a sample's command moves the sampled plant by
// its own error, or the one that a wave line has by itself. Infinite where a command moves nothing.
double StiffnessLimits::scale_stiffness() {
  if (const auto line = family_.line_stiffness()) return *line;
  const SampledPlant& plant = sampled();
  return 1 / std::abs((plant.sense * (plant.phi * plant.recent + plant.recent))(0));
}

StiffnessLimit StiffnessLimits::find_coupled(double virtual_damping) {
  if (!family_.has(virtual_damping)) return {0, false, 0};
  const auto excess = [&](double stiffness) {
    const DiscreteStateSpace law = family_.make(stiffness, virtual_damping);
    return compute_spectral_radius(build_loop_matrix(sampled(), law)) - 1;
  };
  const double scale = scale_stiffness();
  if (!std::isfinite(scale)) return {infinity, true, 0};
  double stable = 1e-7 * scale;
  if (excess(stable) > stability_tolerance) return {0, false, 0};
  double unstable = stable;
  for (;;) {
    unstable = stable * 1.25;
    if (excess(unstable) > stability_tolerance) break;
    stable = unstable;
    if (stable > 1e4 * scale) return {infinity, true, 0};
  }
  // An eigenvalue that stays at one (a device without stiffness of its own) is not the crossing.
  const double at_rest = excess(stable) < -stability_tolerance ? 0 : stability_tolerance;
  std::uintmax_t iterations = 100;
  const auto bracket = boost::math::tools::toms748_solve(
      [&](double stiffness) { return excess(stiffness) - at_rest; }, stable, unstable,
      boost::math::tools::eps_tolerance<double>(44), iterations);
  const double critical = (bracket.first + bracket.second) / 2;
  const DiscreteStateSpace law = family_.make(critical, virtual_damping);
  return {critical, true,
          find_dominant_pole(build_loop_matrix(sampled(), law), period_).frequency_hz};
}

}  // namespace gyrator
