#include "gyrator/controllers/controller.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "support/allocation_count.hpp"
#include "support/law_list.hpp"

namespace gyrator {
namespace {

constexpr double T = 1e-3;
constexpr int steps = 1000;

// In and out of contact every 0.2 s, within the window of an adaptive estimator at the turns.
std::vector<double> make_samples() {
  std::vector<double> samples;
  for (int k = 0; k < steps; ++k) samples.push_back(2e-3 * std::sin(2 * M_PI * 5 * k * T));
  return samples;
}

template <class Step>
long count_allocations(const Step& step) {
  const std::vector<double> samples = make_samples();
  const long before = testing::allocations;
  for (const double y : samples) step(y);
  return testing::allocations - before;
}

TEST(Allocation, is_counted_whoever_asks_for_memory) {
  if (!GYRATOR_COUNTS_ALLOCATIONS) GTEST_SKIP();
  std::vector<double> standard;
  EXPECT_EQ(count_allocations([&](double) { standard = std::vector<double>(standard.size() + 1); }),
            steps);
  Eigen::VectorXd matrix;
  EXPECT_EQ(count_allocations([&](double) { matrix.resize(matrix.size() + 1); }), steps);
}

TEST(Allocation, happens_in_no_step_of_any_law_and_wrapper) {
  if (!GYRATOR_COUNTS_ALLOCATIONS) GTEST_SKIP();
  for (const auto& [name, controller] : testing::make_controller_list()) {
    RunningController running(controller, T);
    std::vector<double> told(running.signal_names().size());
    EXPECT_EQ(count_allocations([&](double y) {
                running.step(y);
                running.read_signals(told);
              }),
              0)
        << name;
  }
}

TEST(Allocation, happens_in_no_step_of_any_velocity_estimator) {
  if (!GYRATOR_COUNTS_ALLOCATIONS) GTEST_SKIP();
  for (const auto& [name, estimator] : testing::make_estimator_list()) {
    RunningVelocityEstimator running(estimator, T);
    EXPECT_EQ(count_allocations([&](double y) { running.step(y); }), 0) << name;
  }
}

}  // namespace
}  // namespace gyrator
