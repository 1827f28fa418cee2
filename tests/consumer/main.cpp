// The textbook plant of cases.md, case 1, through the installed library: K <= 2 b/T = 1600 N/m.
#include <cmath>
#include <cstdio>
#include <gyrator/passivity/stiffness_limit.hpp>

int main() {
  gyrator::Device device;
  device.motion = gyrator::Motion::linear;
  device.mechanics.inertia = 0.04;
  device.mechanics.damping = 0.8;
  gyrator::StiffnessLimits limits(device, {gyrator::Rational(1, 1000), 0},
                                  gyrator::DifferenceEstimator{}, gyrator::FreeOperator{});
  const double limit = limits.find(gyrator::Criterion::exact_disk, 0).stiffness;
  std::printf("largest passive stiffness: %.6f N/m\n", limit);
  return std::abs(limit - 1600) < 1e-3 ? 0 : 1;
}
