#pragma once

#include "gyrator/controllers/law_family.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/aliased_disk.hpp"
#include "gyrator/passivity/frequency_grid.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// What "largest stiffness" means.
enum class Criterion { spring_damper, frequency_dependent, exact_disk, coupled };

/// All of them with their names, in order of presentation.
struct CriterionName {
  Criterion criterion;
  std::string_view name;
  std::string_view summary;
};
const std::vector<CriterionName>& criterion_names();
std::string_view name_of(Criterion criterion);

struct StiffnessLimit {
  double stiffness = 0;   ///< [N/m, N.m/rad]; infinite where nothing bounds it; 0 if not feasible
  bool feasible = false;  ///< false: not even K = 0 meets the criterion at this virtual damping
  double worst_frequency_hz = 0;  ///< where it binds
};

/// Largest virtual stiffness K of a wall over virtual damping B, by one criterion: of a wall from
/// the position, H = K + B V(z), or of one behind a wave line (LawFamily). What does not depend on
/// K and B (the disks, the sampled plant) is computed once. The textbook's two always speak of the
/// wall from the position.
///   spring_damper        K = (b - |B|) 2/T, b = Re Z(0)                                   [8.4]
///   frequency_dependent  Re Z + b_v > 0 at every frequency                               [8.46]
///   exact_disk           D(w) > 0 of (disk-3) at every frequency
///   coupled              the exact loop with the given operator is stable
class StiffnessLimits {
 public:
  StiffnessLimits(const Device& device, const Sampling& sampling,
                  const VelocityEstimator& estimator, const Operator& held_by);
  /// Of the wall of the controller's kind; `controller` without one: from the position.
  StiffnessLimits(const Device& device, const Sampling& sampling, const Controller& controller,
                  const Operator& held_by, GridDensity density = GridDensity::fine);

  /// By the exact disk: proved between the grid's points too (prove_disk), a thousandth
  /// below it or closer; 0 and not feasible where that does not come out.
  StiffnessLimit find(Criterion criterion, double virtual_damping);
  /// By the exact disk at the grid's frequencies and the dips they show alone: for a great many
  /// devices. A law with poles of its own (a wave line) may have a narrow dip in between.
  StiffnessLimit find_on_grid(double virtual_damping);
  /// What that cannot exceed: the lowest of every eighth of its frequencies. For who needs the
  /// limit only where it is high.
  double find_upper_bound(double virtual_damping);

  AliasedDisk& disk() { return disk_; }
  const std::vector<double>& grid() const { return grid_; }
  const std::vector<DiskPoint>& disks();

 private:
  StiffnessLimit find_spring_damper(double virtual_damping);
  StiffnessLimit find_frequency_dependent(double virtual_damping);
  StiffnessLimit find_exact_disk(double virtual_damping);
  StiffnessLimit find_coupled(double virtual_damping);
  bool is_stable(double stiffness, double virtual_damping) const;
  double find_disk_limit(const DiskPoint& disk, const LawFamily::Point& law,
                         double virtual_damping) const;
  template <class Function>
  StiffnessLimit find_lowest(const Function& limit_at, const std::vector<double>& values);
  const std::vector<LawFamily::Point>& laws();
  const SampledPlant& sampled();
  double scale_stiffness();

  Device device_;
  Sampling sampling_;
  double period_;
  LawFamily family_;
  LawFamily position_family_;
  Operator operator_;
  AliasedDisk disk_;
  std::vector<double> grid_;
  std::vector<DiskPoint> disks_;
  std::vector<LawFamily::Point> laws_;
  struct PositionTerm {
    LawFamily::Point law;
    double damping;  // Re Z
  };
  std::vector<PositionTerm> position_terms_;
  std::optional<SampledPlant> sampled_;
};

}  // namespace gyrator
