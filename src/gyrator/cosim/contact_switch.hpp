#pragma once

#include "gyrator/cosim/engine.hpp"
#include "gyrator/mechanics/plant_modes.hpp"

#include <memory>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// Friction and stops of a plant for an engine that integrates: in each of their modes, their
/// efforts as functions of [ξ; U] and the guards that end it. What is piecewise linear in the
/// circuit stays with PlantDynamics.
class ContactSwitch {
 public:
  /// Most guards that any mode has.
  static constexpr int most_guards = 4;

  /// `plant` must have contacts and outlive this.
  explicit ContactSwitch(const Plant& plant) : plant_(plant), modes_(plant, false) {}

  Modes start(const Eigen::VectorXd& xi) const { return modes_.start(xi); }
  const std::string& name_of(int guard) const;

  /// Takes a mode; the functions below are of it.
  void enter(const Modes& modes);

  /// Fills in the contacts of z = [ξ; U], whose ports are solved.
  void close(Eigen::VectorXd& z);
  /// Contacts per [ξ; U].
  const Eigen::MatrixXd& closed() const { return now_->closed; }

  int guards() const { return static_cast<int>(now_->guards.size()); }
  double value(int guard, const Eigen::VectorXd& z) const;
  /// How large the terms of a guard are where those of ξ are `sizes`.
  double size(int guard, const Eigen::VectorXd& sizes) const;

  /// Changes modes as a guard says; a shaft that has come to rest is held at exactly that.
  void change(int guard, Modes& modes, Eigen::Ref<Eigen::MatrixXd> xi);
  void count(int guard, ContactEvents& events) const;
  /// Takes the rounding of a run out of v = 0.
  void hold(Eigen::Ref<Eigen::MatrixXd> xi) const;

  /// The modes in which the port lies on a stop.
  std::vector<Modes> touching() const;

 private:
  struct Known {
    Modes key;
    Eigen::MatrixXd closed;
    std::vector<ModeGuard> guards;
  };
  const Plant& plant_;
  PlantModes modes_;
  std::vector<std::unique_ptr<Known>> known_;
  const Known* now_ = nullptr;
  Eigen::Vector3d efforts_;
};

}  // namespace gyrator
