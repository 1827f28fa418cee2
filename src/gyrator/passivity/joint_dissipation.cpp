#include "gyrator/passivity/joint_dissipation.hpp"

#include <cassert>
#include <limits>

#include <Eigen/Eigenvalues>

namespace gyrator {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Largest {
  double eigenvalue = 0;
  VectorXd vector;
};

// Of wanted q = lambda given q.
Largest find_largest(const MatrixXd& wanted, const MatrixXd& given) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(wanted, given);
  const Eigen::Index last = wanted.rows() - 1;
  return {solver.eigenvalues()(last), solver.eigenvectors().col(last)};
}

double one_over(double eigenvalue) {
  return eigenvalue > 0 ? 1 / eigenvalue : std::numeric_limits<double>::infinity();
}

}  // namespace

PoseDissipation compute_pose_dissipation(const MatrixXd& joint_damping, const MatrixXd& jacobian,
                                         const std::optional<MatrixXd>& task_damping) {
  assert(joint_damping.rows() == jacobian.cols() && joint_damping.cols() == jacobian.cols());
  PoseDissipation pose;
  const Largest weakest = find_largest(jacobian.transpose() * jacobian, joint_damping);
  pose.largest_isotropic = one_over(weakest.eigenvalue);
  pose.weakest_direction = (jacobian * weakest.vector).normalized();
  // The sign of a direction means nothing: its largest component is positive.
  Eigen::Index largest = 0;
  pose.weakest_direction.cwiseAbs().maxCoeff(&largest);
  if (pose.weakest_direction(largest) < 0) pose.weakest_direction *= -1;
  if (!task_damping) return pose;
  assert(task_damping->rows() == jacobian.rows() && task_damping->cols() == jacobian.rows());
  const MatrixXd needed = jacobian.transpose() * *task_damping * jacobian;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> rest(joint_damping - needed,
                                                     Eigen::EigenvaluesOnly);
  pose.least_eigenvalue = rest.eigenvalues()(0);
  pose.allowed_factor = one_over(find_largest(needed, joint_damping).eigenvalue);
  return pose;
}

}  // namespace gyrator
