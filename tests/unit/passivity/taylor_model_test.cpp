#include "gyrator/passivity/taylor_model.hpp"

#include <functional>
#include <random>
#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double reach = 0.3;
// Rounding of a dozen operations on numbers of order ten.
constexpr double noise = 1e-13;

// q(t) = a + b t + c t^2, whose model is known exactly.
struct Known {
  Complex a, b, c;
  Complex at(double t) const { return a + b * t + c * t * t; }
  TaylorModel model() const { return {a, b, std::abs(c), reach}; }
};

class TaylorModels : public ::testing::Test {
 protected:
  Complex draw() { return {uniform_(engine_), uniform_(engine_)}; }
  Known draw_known() { return {draw(), draw(), draw()}; }

  // The model holds at every t of its reach.
  void expect_bounds(const TaylorModel& model, const std::function<Complex(double)>& function,
                     const std::string& what) {
    for (int i = -20; i <= 20; ++i) {
      const double t = reach * i / 20;
      const double rest = std::abs(function(t) - model.value - model.slope * t);
      EXPECT_LE(rest, model.curvature * t * t + noise * (1 + std::abs(function(t))))
          << what << " at " << t;
      EXPECT_GE(std::real(function(t)), model.lowest_real() - noise) << what << " at " << t;
    }
  }

  std::mt19937_64 engine_{11};
  std::uniform_real_distribution<double> uniform_{-2, 2};
};

TEST_F(TaylorModels, bound_sums_products_and_parts_over_the_whole_reach) {
  for (int i = 0; i < 50; ++i) {
    const Known p = draw_known();
    const Known q = draw_known();
    const TaylorModel a = p.model();
    const TaylorModel b = q.model();
    expect_bounds(
        a + b, [&](double t) { return p.at(t) + q.at(t); }, "sum");
    expect_bounds(
        a - b, [&](double t) { return p.at(t) - q.at(t); }, "difference");
    expect_bounds(
        a * b, [&](double t) { return p.at(t) * q.at(t); }, "product");
    expect_bounds(
        conj(a), [&](double t) { return std::conj(p.at(t)); }, "conjugate");
    expect_bounds(
        real_part(a), [&](double t) { return p.at(t).real(); }, "real part");
    expect_bounds(
        imaginary_part(a), [&](double t) { return p.at(t).imag(); }, "imaginary part");
  }
}

TEST_F(TaylorModels, bound_a_reciprocal_or_say_that_they_know_nothing) {
  int known = 0;
  for (int i = 0; i < 200; ++i) {
    const Known q = draw_known();
    const TaylorModel inverse = reciprocal(q.model());
    if (!std::isfinite(inverse.curvature)) continue;
    ++known;
    expect_bounds(
        inverse, [&](double t) { return 1.0 / q.at(t); }, "reciprocal");
  }
  EXPECT_GT(known, 50);
  // Through zero within the reach there is no bound.
  const Known zero{0.1, 1, 0};
  EXPECT_TRUE(std::isinf(reciprocal(zero.model()).curvature));
}

TEST_F(TaylorModels, have_a_majorant_that_is_never_below_the_magnitude) {
  for (int i = 0; i < 200; ++i) {
    Known q = draw_known();
    if (i % 4 == 0) q.a *= 1e-3;  // nearly through zero
    if (i % 8 == 0) q.a = 0;
    const TaylorModel m = majorant(q.model());
    for (int k = -20; k <= 20; ++k) {
      const double t = reach * k / 20;
      // The majorant is this very parabola.
      const double bound = m.value.real() + m.slope.real() * t + m.curvature * t * t;
      EXPECT_GE(bound, std::abs(q.at(t)) - noise);
    }
  }
}

TEST_F(TaylorModels, divide_by_j_omega_without_losing_what_is_small_at_low_frequency) {
  const double omega = 1;
  for (int i = 0; i < 50; ++i) {
    const Known q = draw_known();
    expect_bounds(
        over_j_omega(q.model(), omega), [&](double t) { return q.at(t) / Complex(0, omega + t); },
        "quotient");
  }
  // j w over j w is one, with nothing left over.
  const TaylorModel one = over_j_omega({Complex(0, omega), Complex(0, 1), 0, 0.9}, omega);
  EXPECT_EQ(one.value, 1.0);
  EXPECT_EQ(one.curvature, 0);
}

}  // namespace
}  // namespace gyrator
