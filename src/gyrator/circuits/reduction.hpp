#pragma once

#include "gyrator/circuits/descriptor.hpp"

#include <string>

#include <Eigen/Dense>

namespace gyrator {

/// A linear function of reduced state, input and the input's derivative.
struct ReducedForm {
  Eigen::RowVectorXd state, input, input_rate;
};

/// An ordinary state space that is equivalent to a descriptor, dw/dt = A w + B u, from which
/// every unknown is recovered:
///   x = recover_state w + recover_input u + recover_rate du/dt                     (red-1)
///
/// Algebraic equations are solved for the unknowns that they determine, and substituted; what
/// is left of E is eliminated again until it is regular. One round suffices at index 1. A
/// second one comes at index 2: an inductor fed by a current source, a loop of capacitors (or
/// of two masses made rigid). There x follows u without a state of its own, and the derivative
/// of u appears; the shift w -> w - F u takes it out of the dynamics, so that it is left only
/// in those unknowns that truly have an impulse at a step of u (the voltage across that
/// inductor). See reduce() for the errors.
struct Reduction {
  Eigen::MatrixXd A, B;
  Eigen::MatrixXd recover_state, recover_input, recover_rate;
  /// Consistent reduced state from any desired x at rest (u = 0): keeps charge and momentum.
  Eigen::MatrixXd initialize;

  /// A network form in terms of the reduced state.
  ReducedForm reduce(const LinearForm& form) const;
};

/// Throws numerical, naming the elements, where the network is singular (a floating node, a loop
/// of ideal voltage sources), and where it would need the second derivative of an input.
Reduction reduce(const Descriptor& descriptor);

}  // namespace gyrator
