#include "gyrator/passivity/pole_rounding.hpp"

#include "gyrator/circuits/state_space.hpp"
#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/passivity/counterexample.hpp"

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

struct Pole {
  std::complex<double> value;
  Eigen::MatrixXd loop;
};

// An undamped mass before a spring that is computed: z^2 - (2 - a/2) z + (1 + a/2) = 0 with
// a = K T^2/m, so that |z|^2 = 1 + a/2 while the poles are complex.
Pole make_slow_pole(double a) {
  const double T = 1e-3;
  const Plant plant =
      build_plant(build_device_network(make_point_mass(1, 0).device, FreeOperator{}));
  const Eigen::MatrixXd loop =
      build_loop_matrix(sample_plant(plant, {Rational(1, 1000), 0}), make_gain(a / (T * T)));
  const Eigen::VectorXcd poles = compute_poles(loop);
  Eigen::Index at = 0;
  poles.cwiseAbs().maxCoeff(&at);
  return {poles(at), loop};
}

TEST(PoleRounding, bounds_the_error_of_a_known_pole_however_slow) {
  for (double a = 1e-1; a > 1e-13; a /= 3) {
    const Pole pole = make_slow_pole(a);
    const double bound = bound_pole_rounding(pole.loop, pole.value);
    // |z| - 1 = (|z|^2 - 1)/(|z| + 1)
    const double growth = a / 2 / (std::sqrt(1 + a / 2) + 1);
    EXPECT_LE(std::abs(std::abs(pole.value) - 1 - growth), bound) << a;
    // … and is worth having: growth far below the tolerance for a double pole is told from one.
    EXPECT_LT(bound, 1e-13) << a;
  }
}

TEST(PoleRounding, is_the_square_root_of_rounding_and_more_for_a_double_pole) {
  // [1 1; 0 1] is moved to 1 ± sqrt(e) by an error e: the first-order bound must not promise less.
  Eigen::MatrixXd loop(2, 2);
  loop << 1, 1, 0, 1;
  EXPECT_GT(bound_pole_rounding(loop, 1.0), 1e-8);
}

TEST(PoleRounding, grows_with_the_condition_of_the_pole) {
  // [1 c; 0 1 + d]: κ = sqrt(1 + (c/d)^2); balancing cannot even out a triangular matrix.
  const auto bound = [](double c) {
    Eigen::MatrixXd loop(2, 2);
    loop << 1, c, 0, 1 + 1e-3;
    return bound_pole_rounding(loop, 1.0 + 1e-3);
  };
  EXPECT_NEAR(bound(0.5) / bound(0), std::sqrt(1 + 0.25e6) * std::sqrt(2.25 / 2), 5);
}

}  // namespace
}  // namespace gyrator
