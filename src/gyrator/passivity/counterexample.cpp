#include "gyrator/passivity/counterexample.hpp"

#include "gyrator/circuits/state_space.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/foster_operator.hpp"
#include "gyrator/passivity/pole_rounding.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlopt.hpp>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// Whether slower growth is more than rounding is asked of the pole itself.
constexpr double clearly_growing = 2e-9;
// … and one that grows a part in a million per sample is not worth improving on.
constexpr double well_growing = 1e-6;
// What growth resonators must bring for an inertia and a spring to be given up.
constexpr double much_faster = 10;
constexpr int refined_candidates = 4;
constexpr int most_aliases_met = 25;
constexpr double most_flops = 4e9;  // a few seconds

// In units of the device's inertia J and of J/T^2; a part below the smallest is left out. Where the
// disk is exceeded below w only, the wall's spring K takes an inertia of K/w^2 to move that slowly.
constexpr double largest_inertia = 1e10;
constexpr double largest_stiffness = 1e2;
constexpr double smallest_part = 1e-7;

bool is_nyquist(double omega, double period) {
  return std::abs(omega * period - std::numbers::pi) < 1e-9;
}

// The reactance with which the operator turns an alias of complex weight k S A to the wanted angle.
double find_reactance(const PortResponse& response, Complex weight, double angle) {
  const double theta = angle - std::arg(weight);
  const Complex disk_element = (1.0 + std::polar(1.0, theta)) / (2 * response.impedance.real());
  return std::imag(1.0 / disk_element - response.impedance);
}

// The reactances that turn the `count` strongest aliases (0, -1, 1, -2 …) to the direction in which
// -1/H lies; at Nyquist those below are the conjugates of those above, and are met with them.
std::vector<WantedReactance> find_wanted(AliasedDisk& disk, double omega, Complex law, double delay,
                                         int count) {
  const double sampling_frequency = 2 * std::numbers::pi / disk.period();
  const bool at_nyquist = is_nyquist(omega, disk.period());
  const DiskPoint point = disk.at(omega);
  const double angle = std::arg(-1.0 / law - point.center);
  std::vector<WantedReactance> wanted;
  for (int i = 0; i < count; ++i) {
    const int alias = i % 2 == 0 ? i / 2 : -(i + 1) / 2;
    if (at_nyquist && alias < 0) continue;
    const double at = omega + alias * sampling_frequency;
    const PortResponse r = disk.model().at(std::abs(at));
    // k_n without its positive factor: -(1 - e^(-jwT)) e^(-jw_n t_d)
    const Complex hold =
        -(1.0 - std::polar(1.0, -omega * disk.period())) * std::polar(1.0, -at * delay);
    const Complex path = r.sensor_path * r.actuation;
    // For a negative frequency everything is conjugate.
    wanted.push_back({std::abs(at), at > 0 ? find_reactance(r, hold * path, angle)
                                           : find_reactance(r, std::conj(hold) * path, -angle)});
  }
  return wanted;
}

// Inertia and spring with M w - k/w = X at w, over the free parameter of the family.
void add_family(const WantedReactance& wanted, double inertia_scale,
                std::vector<MassSpringDamper>& candidates) {
  const double w = wanted.omega;
  const double x = wanted.reactance;
  if (!std::isfinite(x)) return;
  for (const double share : {0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0}) {
    const double size = std::abs(x) + 1e-9 * inertia_scale * w;
    MassSpringDamper held_by;
    if (x >= 0) {  // inertia overcomes the spring
      held_by.stiffness = share * size * w;
      held_by.inertia = (x + held_by.stiffness / w) / w;
    } else {
      held_by.inertia = share * size / w;
      held_by.stiffness = (held_by.inertia * w - x) * w;
    }
    candidates.push_back(held_by);
  }
}

// Inertia and spring that also meet the first alias; none where one would be negative.
std::optional<MassSpringDamper> solve_both(const WantedReactance& base,
                                           const WantedReactance& alias) {
  const double w = base.omega;
  const double v = alias.omega;
  const double x = base.reactance;
  const double y = alias.reactance;
  // M w - k/w = x, M v - k/v = y
  const double determinant = v / w - w / v;
  if (!(std::abs(determinant) > 1e-9)) return std::nullopt;
  const double inertia = (y / w - x / v) / determinant;
  const double stiffness = (y * w - x * v) / determinant;
  if (!(inertia >= 0 && stiffness >= 0)) return std::nullopt;
  return MassSpringDamper{inertia, 0, stiffness, {}};
}

class Search {
 public:
  Search(const Device& device, const Sampling& sampling, const DiscreteStateSpace& law)
      : device_(device), sampling_(sampling), law_(law), gain_(find_amplifier_gain(device)) {}

  double inertia_scale() const {
    const auto& mechanics = device_.mechanics;
    return mechanics.transmission ? mechanics.transmission->load_inertia : mechanics.inertia;
  }
  double stiffness_scale() const {
    return inertia_scale() / std::pow(sampling_.period.to_double(), 2);
  }

  MassSpringDamper without_trifles(MassSpringDamper held_by) const {
    if (held_by.inertia < smallest_part * inertia_scale()) held_by.inertia = 0;
    if (held_by.stiffness < smallest_part * stiffness_scale()) held_by.stiffness = 0;
    return held_by;
  }

  bool in_proportion(const MassSpringDamper& held_by) const {
    return held_by.inertia <= largest_inertia * inertia_scale() &&
           held_by.stiffness <= largest_stiffness * stiffness_scale();
  }

  // The spectral radius is one where rounding cannot tell it from one.
  Counterexample judge(const MassSpringDamper& held_by) const {
    throw_if_interrupted("passivity");
    try {
      const Plant plant = build_plant(build_device_network(device_, held_by, gain_));
      const Eigen::MatrixXd loop = build_loop_matrix(sample_plant(plant, sampling_), law_);
      if (!loop.allFinite()) return {held_by, 0, 0};
      const Eigen::VectorXcd poles = compute_poles(loop);
      Eigen::Index at = 0;
      const double radius = poles.cwiseAbs().maxCoeff(&at);
      const double frequency =
          std::abs(std::arg(poles(at))) / (2 * std::numbers::pi * sampling_.period.to_double());
      const bool slow = radius > 1 && radius < 1 + clearly_growing;
      const bool certain = !slow || radius - 1 > bound_pole_rounding(loop, poles(at));
      return {held_by, certain ? radius : 1, frequency};
    } catch (const std::exception&) {  // values out of all proportion: not a candidate
      return {held_by, 0, 0};
    }
  }

  // Leaves out parts that do not matter: a plain inertia says more than one with a weak spring.
  Counterexample simplify(const Counterexample& found) const {
    Counterexample simplest = found;
    for (double MassSpringDamper::*part :
         {&MassSpringDamper::stiffness, &MassSpringDamper::inertia}) {
      MassSpringDamper without = simplest.held_by;
      without.*part = 0;
      const Counterexample candidate = judge(without);
      if (candidate.spectral_radius - 1 >= 0.9 * (found.spectral_radius - 1)) simplest = candidate;
    }
    return simplest;
  }

  // Local improvement over the logarithms of all parts, present or not.
  Counterexample improve(const Counterexample& start, int evaluations) const {
    std::vector<double> x{std::log(start.held_by.inertia), std::log(start.held_by.stiffness)};
    std::vector<double> lower{std::log(smallest_part * inertia_scale()),
                              std::log(smallest_part * stiffness_scale())};
    std::vector<double> upper{std::log(largest_inertia * inertia_scale()),
                              std::log(largest_stiffness * stiffness_scale())};
    Counterexample best = start;
    nlopt::opt optimizer(nlopt::LN_NELDERMEAD, static_cast<unsigned>(x.size()));
    nlopt::vfunc objective = [](const std::vector<double>& v, std::vector<double>&, void* data) {
      auto& [search, found] = *static_cast<std::pair<const Search*, Counterexample*>*>(data);
      const Counterexample candidate = search->judge({std::exp(v[0]), 0, std::exp(v[1]), {}});
      if (candidate.spectral_radius > found->spectral_radius) *found = candidate;
      return candidate.spectral_radius;
    };
    std::pair<const Search*, Counterexample*> data{this, &best};
    optimizer.set_max_objective(objective, &data);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::clamp(x[i], lower[i], upper[i]);
    optimizer.set_lower_bounds(lower);
    optimizer.set_upper_bounds(upper);
    optimizer.set_maxeval(evaluations);
    optimizer.set_xtol_rel(1e-4);
    optimizer.set_initial_step(0.3);
    double value = 0;
    try {
      optimizer.optimize(x, value);
    } catch (const nlopt::roundoff_limited&) {
      // The best point so far is kept.
    }
    return best;
  }

 private:
  const Device& device_;
  const Sampling& sampling_;
  const DiscreteStateSpace& law_;
  double gain_;
};

// Eigenvalues of a loop with so many states on top of the device's own.
double count_flops(double more_states) {
  return 25 * std::pow(10 + more_states, 3);
}

// Operators that meet more and more aliases, with a resonator for each.
Counterexample meet_aliases(const Search& search, AliasedDisk& disk, const DiscreteStateSpace& law,
                            const Sampling& sampling, const std::vector<double>& failing_omega) {
  const auto delay_states = static_cast<double>(split_delay(sampling).whole);
  Counterexample best;
  double flops = 0;
  const std::size_t stride = std::max<std::size_t>(1, failing_omega.size() / 12);
  for (const int count : {3, 5, 9, 17, 25, 49, 81}) {
    for (std::size_t i = 0; i < failing_omega.size(); i += stride) {
      const double omega = failing_omega[i];
      // Each alias more brings the bound nearer by 1/count; at Nyquist half of them come for
      // nothing.
      if (count > most_aliases_met && !is_nyquist(omega, disk.period())) continue;
      const auto wanted =
          find_wanted(disk, omega, law.response(std::polar(1.0, omega * disk.period())),
                      sampling.delay.to_double(), count);
      for (const double nearness : {0.45, 0.25, 0.1}) {
        for (const double both : {0.0, 1.0}) {
          const auto held_by = interpolate_reactances(wanted, nearness, both);
          if (!held_by) continue;
          const Counterexample candidate = search.judge(*held_by);
          if (candidate.spectral_radius > best.spectral_radius) best = candidate;
          flops += count_flops(delay_states + 2 * static_cast<double>(wanted.size()));
        }
      }
      if (best.spectral_radius > 1 + well_growing || flops > most_flops) return best;
    }
  }
  return best;
}

}  // namespace

Counterexample judge_operator(const Device& device, const Sampling& sampling,
                              const DiscreteStateSpace& law, const MassSpringDamper& held_by) {
  const DominantPole pole = find_dominant_pole(build_device_loop(device, held_by, sampling, law),
                                               sampling.period.to_double());
  return {held_by, pole.magnitude, pole.frequency_hz};
}

std::optional<Counterexample> find_counterexample(const Device& device, const Sampling& sampling,
                                                  const DiscreteStateSpace& law, AliasedDisk& disk,
                                                  const std::vector<double>& failing_omega) {
  const Search search(device, sampling, law);
  const double delay = sampling.delay.to_double();
  // Let go, and all but held still.
  std::vector<MassSpringDamper> operators{
      MassSpringDamper{}, {1e-2 * largest_inertia * search.inertia_scale(), 0, 0, {}}};
  for (const double omega : failing_omega) {
    const auto wanted =
        find_wanted(disk, omega, law.response(std::polar(1.0, omega * disk.period())), delay, 3);
    add_family(wanted[0], search.inertia_scale(), operators);
    if (wanted.size() < 2) continue;  // none below at Nyquist
    if (const auto both = solve_both(wanted[0], wanted[1])) operators.push_back(*both);
  }
  // A loop with a long delay has a large matrix: there the search is kept to a few seconds.
  const auto delay_states = static_cast<double>(split_delay(sampling).whole);
  const int affordable =
      static_cast<int>(std::clamp(most_flops / count_flops(delay_states), 8.0, 1e4));
  std::vector<Counterexample> candidates;
  for (const auto& held_by : operators) {
    if (static_cast<int>(candidates.size()) >= affordable) break;
    if (search.in_proportion(held_by))
      candidates.push_back(search.judge(search.without_trifles(held_by)));
  }
  const auto stronger = [](const Counterexample& a, const Counterexample& b) {
    return a.spectral_radius > b.spectral_radius;
  };
  std::sort(candidates.begin(), candidates.end(), stronger);

  // Refine a few of the best, of which the strongest wins; resonators only where these do not do.
  Counterexample best = candidates.front();
  const std::size_t count = std::min<std::size_t>(refined_candidates, candidates.size());
  for (std::size_t i = 0; i < count && best.spectral_radius < 1 + 1e-4; ++i) {
    const Counterexample refined =
        search.improve(candidates[i], std::min(80, affordable / refined_candidates));
    if (stronger(refined, best)) best = refined;
  }
  // Aliases count where the disk is exceeded at frequencies that are not slow against the sampling.
  const double fastest = *std::max_element(failing_omega.begin(), failing_omega.end());
  const bool sampled_counts = fastest * disk.period() > 0.01 * std::numbers::pi;
  const double wanted_growth = sampled_counts ? clearly_growing : 0;
  if (!(best.spectral_radius > 1 + wanted_growth)) {
    const Counterexample found = meet_aliases(search, disk, law, sampling, failing_omega);
    if (found.spectral_radius - 1 > much_faster * (best.spectral_radius - 1)) best = found;
  }
  if (!(best.spectral_radius > 1)) return std::nullopt;
  return search.simplify(best);
}

}  // namespace gyrator
