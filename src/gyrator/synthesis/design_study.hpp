#pragma once

#include "gyrator/core/statistics.hpp"
#include "gyrator/synthesis/design_search.hpp"

#include <optional>
#include <string>
#include <vector>

namespace gyrator {

/// Largest passive stiffness over virtual damping.
struct Boundary {
  std::vector<double> damping, max_stiffness;
};

/// A design as reported: parts that can be had, its limit proved.
struct Design {
  Candidate candidate;
  double rated_stiffness = 0;  ///< of the wall in its model
  Share yield;
  OperatingExtremes extremes;  ///< the worst over winding_rise, during the operation
  nlohmann::json model;        ///< the file that reproduces it
  Boundary boundary;           ///< of its device and controller, for pictures
  std::string reason;          ///< why it loses against the first; empty for the first
};

/// What one topology can do: the lightest of each stiffness.
struct TopologyFront {
  const Topology* topology = nullptr;
  std::vector<Candidate> points;
};

/// A topology without a design that keeps every constraint.
struct InfeasibleTopology {
  const Topology* topology = nullptr;
  std::string because;
};

/// A constraint that a candidate misses.
struct MissedConstraint {
  std::string name;
  Unit unit;
  double limit = 0;   ///< as asked for
  double needed = 0;  ///< to which it would have to give
};

/// Why nothing is feasible.
struct BindingConstraint {
  std::string name;
  Unit unit;
  double limit = 0;   ///< as asked for
  double needed = 0;  ///< to which it would have to give, the others kept
  bool alone = true;  ///< whether giving way in this one is enough
  std::string topology;
  std::vector<MissedConstraint> others = {};  ///< that would have to give with it, where known
};

struct DesignStudy {
  std::vector<Design> designs;        ///< best first; none: infeasible
  std::vector<Candidate> continuous;  ///< best of each option without a series
  std::vector<Candidate> pareto;      ///< stiffness against apparent inertia, the lightest first
  std::vector<TopologyFront> fronts;  ///< the same of each topology by itself
  std::vector<InfeasibleTopology> infeasible;  ///< in the order of the spec
  std::optional<BindingConstraint> binding;    ///< where infeasible and a constraint is to blame
};

/// Chooses topology and values. `quiet`: no progress bar.
DesignStudy run_design_study(const DesignSpec& spec, bool quiet);

}  // namespace gyrator
