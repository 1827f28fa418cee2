#include "gyrator/passivity/joint_dissipation.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(JointDissipation, of_a_lever_is_its_damper_over_the_length_squared) {
  const MatrixXd damping = MatrixXd::Constant(1, 1, 2e-3);
  const MatrixXd lever = MatrixXd::Constant(1, 1, 0.1);
  for (const double factor : {0.999, 1.001}) {
    const MatrixXd needed = MatrixXd::Constant(1, 1, 0.2 * factor);  // 2e-3/0.1^2
    const PoseDissipation pose = compute_pose_dissipation(damping, lever, needed);
    EXPECT_NEAR(pose.largest_isotropic, 0.2, 1e-15);
    EXPECT_NEAR(pose.allowed_factor.value(), 1 / factor, 1e-12);
    EXPECT_EQ(pose.least_eigenvalue.value() > 0, factor < 1);
    EXPECT_NEAR(pose.least_eigenvalue.value(), 2e-3 * (1 - factor), 1e-15);
  }
  const PoseDissipation still = compute_pose_dissipation(damping, MatrixXd::Zero(1, 1), {});
  EXPECT_TRUE(std::isinf(still.largest_isotropic));
  EXPECT_FALSE(still.allowed_factor.has_value());
}

TEST(JointDissipation, is_least_across_an_outstretched_arm) {
  // Two links of 0.2 m along x, equal dampers: J^T J = 0.04 [4 2; 2 1] has the eigenvalue 0.2.
  MatrixXd jacobian(2, 2);
  jacobian << 0, 0, 0.4, 0.2;
  const PoseDissipation pose =
      compute_pose_dissipation(1e-3 * MatrixXd::Identity(2, 2), jacobian, {});
  EXPECT_NEAR(pose.largest_isotropic, 1e-3 / 0.2, 1e-15);
  EXPECT_NEAR(pose.weakest_direction(1), 1, 1e-12);
  EXPECT_NEAR(pose.weakest_direction(0), 0, 1e-12);
}

TEST(JointDissipation, no_joint_velocity_loses_less_than_the_task_damping_asks_for) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto fill = [&](long rows, long columns) {
    return MatrixXd(MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }));
  };
  for (int trial = 0; trial < 50; ++trial) {
    const MatrixXd a = fill(3, 3);
    const MatrixXd d = fill(2, 2);
    const MatrixXd joints = a * a.transpose() + 0.1 * MatrixXd::Identity(3, 3);
    const MatrixXd task = d * d.transpose();
    const MatrixXd jacobian = fill(2, 3);
    const PoseDissipation pose = compute_pose_dissipation(joints, jacobian, task);
    double closest = INFINITY;
    for (int i = 0; i < 3000; ++i) {
      const VectorXd q = fill(3, 1);
      const VectorXd x = jacobian * q;
      const double lost = q.dot(joints * q);
      EXPECT_GE(lost, pose.allowed_factor.value() * x.dot(task * x) * (1 - 1e-9));
      EXPECT_GE(lost, pose.largest_isotropic * x.squaredNorm() * (1 - 1e-9));
      closest = std::min(closest, lost / (pose.largest_isotropic * x.squaredNorm()));
    }
    EXPECT_LT(closest, 1.3);  // and it is hardly larger than it need be: 3000 directions of three
    // The eigenvalue is below zero exactly where the factor is below one.
    EXPECT_EQ(pose.least_eigenvalue.value() < 0, pose.allowed_factor.value() < 1);
  }
}

}  // namespace
}  // namespace gyrator
