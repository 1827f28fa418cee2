#pragma once

#include <Eigen/Dense>

namespace gyrator {

/// The first point of (0, 1] at which a polynomial is below zero, or 2.
///   p(x) = c_0 + c_1 x + c_2 x² + …
/// Located to the last bit; a dip between twelfths of the way is found where the slope changes its
/// sign between them.
double find_first_negative(const Eigen::VectorXd& c);

}  // namespace gyrator
