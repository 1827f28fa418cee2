#pragma once

#include "gyrator/synthesis/design_spec.hpp"
#include "gyrator/synthesis/digital_stage.hpp"
#include "gyrator/synthesis/lattice_search.hpp"

#include <optional>
#include <span>
#include <vector>

namespace gyrator {

/// How the limit of a candidate is found: at the grid's frequencies for a search, proved between
/// them for what is reported.
enum class LimitPrecision { on_grid, proved };

/// One option of a spec: what there is to choose, and what a choice is worth. From many threads
/// at once.
class DesignProblem {
 public:
  DesignProblem(const DesignSpec& spec, const DesignOption& option);

  const DesignSpec& spec() const { return spec_; }
  const DesignOption& option() const { return option_; }
  std::size_t size() const { return option_.values.size(); }

  /// Values that can be had of each variable, rising. Throws bad_input, naming the range, where a
  /// series has none in it.
  std::vector<std::vector<double>> lattice() const;

  /// On the grid, a limit is left out where a constraint that does not ask for it is missed; not
  /// for `free`, which may be.
  DesignFigures evaluate(std::span<const double> values,
                         LimitPrecision precision = LimitPrecision::on_grid,
                         const DesignConstraint* free = nullptr) const;
  /// The merit of these values, or none where it is no better than `least`. That is cheap where a
  /// constraint is missed or an upper bound of the stiffness is no higher.
  std::optional<DesignMerit> find_merit_above(const DesignMerit& least,
                                              std::span<const double> values) const;
  /// The same of a device that is not one of the search's, without its limits and stability.
  DesignFigures evaluate_port(const Device& device, const Controller& controller) const;

  Device make_device(std::span<const double> values) const;
  /// Set up for that device.
  Controller make_controller(const Device& device, std::span<const double> values) const {
    return stage_.make(device, values);
  }

 private:
  OperatingExtremes find_extremes(const Device& device, const Controller& controller) const;
  bool misses_any(const DesignFigures& figures, const DesignConstraint* free) const;
  double find_highest_stiffness(const Device& device, const Controller& controller) const;
  void add_limits(DesignFigures& figures, const Device& device, const Controller& controller,
                  LimitPrecision precision) const;

  const DesignSpec& spec_;
  const DesignOption& option_;
  Device device_;  // with the damping at the end of its list
  DigitalStage stage_;
  std::vector<double> rises_;
  double rigid_inertia_ = 0;
  bool needs_extremes_ = false;
};

/// By how much a constraint is missed: log of value over limit (limit over value of a minimum), at
/// most `hopeless`; 0 where it is kept.                                            (design-1)
double find_violation(const DesignConstraint& constraint, const DesignFigures& figures);
inline constexpr double hopeless = 50;

/// Merit under the spec: feasible where all constraints are kept and some stiffness is passive; the
/// score is the objective, or minus the sum of violations, where that of an unknown limit is twice
/// `hopeless`. With `free` that one may be missed by
/// any amount, and the score is by how little.
DesignMerit judge(const DesignSpec& spec, const DesignFigures& figures,
                  const DesignConstraint* free = nullptr);

}  // namespace gyrator
