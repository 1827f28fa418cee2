#include "gyrator/controllers/velocity_response.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/estimator_errors.hpp"

// docs/velocity-estimators.md says what is measured.

namespace gyrator::estimator_errors {
namespace {

// Cells of the page's row that begins with the name; the page is read from the project's folder.
std::vector<std::string> read_row(const std::string& name) {
  std::ifstream page("docs/velocity-estimators.md");
  for (std::string line; std::getline(page, line);) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, '|');) cells.push_back(cell);
    if (cells.size() == 7 && cells[1] == " " + name + " ") return cells;
  }
  return {};
}

TEST(VelocityAccuracy, is_what_the_page_on_estimators_says) {
  for (const auto& [name, estimator] : make_estimators()) {
    const auto cells = read_row(name);
    ASSERT_EQ(cells.size(), 7U) << name;
    constexpr double last_digit = 0.51;  // half of it, and rounding
    if (find_velocity_law(estimator, period)) {
      EXPECT_NEAR(std::stod(cells[2]), 1e3 * compute_velocity_delay(estimator, period),
                  last_digit * 0.01);
      EXPECT_NEAR(std::stod(cells[3]), compute_velocity_noise_gain(estimator, period),
                  last_digit * 0.1);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(std::stod(cells[4 + i]), measure_error(estimator, make_motions()[i]),
                  last_digit * 1e-4)
          << name << ", " << make_motions()[i].name;
    }
  }
}

TEST(VelocityAccuracy, of_a_difference_is_best_at_the_window_that_trades_noise_for_blur) {
  // Quantization as white noise, D^2/(6 t^2), and a delay t/2 of the acceleration a: least at
  // t = (2/3)^(1/4) sqrt(D/a).                                                       (est-9)
  const Motion swing = make_motions().back();
  const double a = 0.2 * std::pow(4 * std::numbers::pi, 2) / std::sqrt(2);
  const auto expected = [&](int n) {
    const double tau = n * period;
    return std::sqrt(quantum * quantum / (6 * tau * tau) + a * a * tau * tau / 4);
  };
  const double best = std::pow(2.0 / 3, 0.25) * std::sqrt(quantum / a) / period;
  double least = 1;
  int least_at = 0;
  for (int n = 1; n <= 20; ++n) {
    const double error = measure_error(DifferenceEstimator{n}, swing);
    // Roundings some samples apart are not quite independent, and the velocity is no white signal.
    EXPECT_NEAR(error / expected(n), 1, 0.15) << n;
    if (error < least) least_at = n;
    least = std::min(least, error);
  }
  EXPECT_NEAR(least_at, best, 1.5);
}

}  // namespace
}  // namespace gyrator::estimator_errors
