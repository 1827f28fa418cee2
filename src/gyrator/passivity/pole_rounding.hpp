#pragma once

#include <complex>

#include <Eigen/Dense>

namespace gyrator {

/// How far rounding may have moved a simple pole of a sampled loop, to first order:
///   |Δz| <= safety n ε max(1, |L|) κ,   κ = |x| |y| / |y' x|                        (rounding-1)
/// L the loop's matrix of n rows, balanced, |L| its Frobenius norm, x and y the pole's right and
/// left eigenvectors, ε of double. The safety, 3, covers the matrix exponential that L was made
/// with. Infinite for a multiple pole. A loop whose slowest motion lasts for millions of samples
/// has its poles that close to one, and they are known far better than to 1e-9.
/// Source: Golub and Van Loan 2013, section 7.2.2.
double bound_pole_rounding(const Eigen::MatrixXd& loop, std::complex<double> pole);

}  // namespace gyrator
