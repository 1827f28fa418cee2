#pragma once

#include "gyrator/circuits/network.hpp"

#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// The network at rest: its constant sources on, every input of its own zero, nothing moving.
struct OperatingPoint {
  Eigen::VectorXd unknowns;       ///< as in the network's descriptor
  Eigen::VectorXd port_inputs;    ///< w of each nonlinear element, in order
  std::vector<double> arguments;  ///< of each nonlinear element, in order
  std::vector<double> slopes;     ///< of each element's law; 0 for linear ones
};

/// Finds it: 0 = A x + W w(y) + c with all mechanical nodes held at velocity zero; a part of x that
/// stays undetermined is zero. Without constant sources every law rests at zero. A flat law's slope
/// is zero unless the network would then be singular; its leak otherwise.
/// Throws numerical, naming elements, where there is none (a constant current into a capacitor).
OperatingPoint find_operating_point(const Network& network);

/// Over which size of its argument a nonlinear element keeps the slope that the linear tools use.
struct LinearRange {
  ElementId element;
  enum class Quantity { voltage, current, velocity, effort, command, temperature_rise } quantity;
  double at = 0;            ///< argument at the operating point [SI]
  double from = 0, to = 0;  ///< the slope stays within 1 %; infinite where it always does
};
std::vector<LinearRange> find_linear_ranges(const Network& network);

}  // namespace gyrator
