#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/cosim/simulation.hpp"
#include "gyrator/mechanics/plant.hpp"

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// A linear plant from sample to sample, as lanes advance it:
///   ξ[k+1] = phi ξ[k] + late u[k-m-1] + recent u[k-m] + pushed f[k]              (lane-1)
/// with u the converted command, t_d = m T + rest, `late` zero without a rest, and f the effort at
/// the port, held over the period.
struct LanePlant {
  Eigen::MatrixXd propagate;  ///< [phi late recent pushed]
  Eigen::RowVectorXd sensed, position, velocity;
  double largest_push = 0;  ///< largest rate of a state per effort at the port
  SplitDelay delay;
  Eigen::VectorXd scale;  ///< of each state here, against the plant's own
  Plant plant;            ///< for states at the start

  Eigen::VectorXd initial_state(double at, double moving) const {
    return scale.cwiseProduct(plant.initial_state(at, moving));
  }

  Eigen::Index states() const { return propagate.rows(); }
};

/// Throws bad_input, saying which, for a plant that is not linear or whose signals jump with the
/// command: that is for the engines.
LanePlant make_lane_plant(const Plant& plant, const Sampling& sampling);

/// A linear law from sensed position to command with at most one switch:
///   q[k+1] = A q + B y,   effort = C q + D y where y > contact_threshold, else 0   (lane-2)
struct LaneLaw {
  DiscreteStateSpace law;
  double contact_threshold = 0;  ///< -infinity: acts everywhere
  double least_effort = 0;       ///< 0: may not pull; -infinity: may
  /// Law state for a first sample of one: as if it had been there for ever.
  Eigen::VectorXd settled_at_one;
};

/// None for a controller that is more than that.
std::optional<LaneLaw> find_lane_law(const Controller& controller, double period);

/// What all lanes of a run have in common beside the plant's size.
struct LaneScene {
  Sensor sensor;
  Sampling sampling;
  /// duration, start, efforts, gesture, converter, seed and classification count; the rest does
  /// not.
  SimulationOptions options;
};

/// Why a run cannot be done in lanes, as half a sentence; empty where it can.
std::string find_lane_obstacle(const Plant& plant, const Controller& controller,
                               const LaneScene& scene);

}  // namespace gyrator
