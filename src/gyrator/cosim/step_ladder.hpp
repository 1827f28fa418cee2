#pragma once

#include <array>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// Exact steps of dξ/dt = R z, z = [ξ; constants], of length h, h/2, h/4 …, and Taylor series for
/// any length that is shorter than the last of them.
///   ξ(t + 2h) = ξ + (2 C + C_ξ C) z,  C(h) = [e^(A h) - I, ∫ e^(A s) ds B]        (ladder-1)
///   E(2h) = E(h) + e^(A_z h)' E(h) e^(A_z h),  work over h = z' E z               (ladder-2)
/// Every step is kept as a difference from the identity, so that nothing is lost to rounding where
/// it is short. The last step h/2^k is the first that is short against the fastest pole,
/// |A| h/2^k <= 1/4 with A balanced: from there the series is exact in a dozen terms. Where a
/// switching must be found inside a step, that series is a polynomial to be solved.
class StepLadder {
 public:
  using Work = std::array<double, 3>;

  /// `forms`: three quadratic forms of z [W] to integrate, or none. `longest` [s] > 0.
  StepLadder(const Eigen::MatrixXd& rate, const std::vector<Eigen::MatrixXd>& forms,
             double longest);

  int steps() const { return static_cast<int>(steps_.size()); }
  double length(int step) const { return steps_[static_cast<std::size_t>(step)].length; }

  /// ξ at the end of a step from z.
  void move(int step, const double* z, double* xi) const;
  /// Adds the work of that step.
  void book(int step, const double* z, Work& work) const;

  /// The series of z over `length`, which must not exceed the shortest step's.
  void expand(const double* z, double length);
  /// ξ and work at a part (0 … 1) of that length.
  void move_to(double part, double* xi) const;
  void book_to(double part, Work& work) const;
  /// Coefficients of row z(part) in powers of `part`: row times this.
  const Eigen::MatrixXd& series() const { return series_; }

  /// Moves z's ξ any length: whole steps, then a series. Books where there are forms.
  void travel(double length, Eigen::VectorXd& z, Work& work);

  /// A bound of the fastest rate [1/s], balanced.
  double rate() const { return rate_bound_; }

 private:
  struct Step {
    double length;
    Eigen::MatrixXd change;                             // C
    Eigen::Matrix<double, 3, Eigen::Dynamic> energies;  // packed upper triangles of E
  };
  void build(double longest, int count);

  Eigen::MatrixXd rate_;
  std::vector<Eigen::MatrixXd> forms_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> packed_forms_;
  Eigen::Index n_, size_;
  double rate_bound_ = 0;
  std::vector<Step> steps_;  ///< longest first
  Eigen::MatrixXd series_;
  double expanded_ = 0;
  mutable Eigen::VectorXd at_;
};

}  // namespace gyrator
