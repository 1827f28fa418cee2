#include "gyrator/circuits/nonlinear_law.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

// Every law that only takes energy, at values as they occur.
const std::vector<ElementLaw> dissipative{
    Diode{},
    Diode{.saturation_current = 2e-9, .emission_voltage = 0.045},
    VoltageClamp{.voltage = 24, .resistance = 0.1},
    SaturatingConductance{.conductance = 3e-3, .limit = 0.2},
    CurrentLimiter{.current = 5, .resistance = 1000},
    ThermalResistor{.resistance = 2,
                    .temperature_coefficient = 0.004,
                    .thermal_resistance = 5,
                    .thermal_capacity = 10},
};
const std::vector<ElementLaw> sources{
    LimitedVoltageControlledVoltageSource{1e5, 12, {}, {}},
    LimitedVoltageControlledCurrentSource{-0.3, 5, {}, {}},
};

std::vector<ElementLaw> all_laws() {
  std::vector<ElementLaw> laws = dissipative;
  laws.insert(laws.end(), sources.begin(), sources.end());
  return laws;
}

double size_of(const ElementLaw& law) {
  return make_port({"x", Role::device, {1}, ground, law}).size;
}

TEST(NonlinearLaw, dissipates_and_rises_everywhere_where_it_is_no_source) {
  for (const ElementLaw& law : dissipative) {
    double below = -INFINITY;
    for (double part = -60; part <= 60; part += 0.0625) {
      const double y = part * size_of(law);
      const LawPoint at = evaluate_law(law, y, 30);
      EXPECT_GE(y * at.value, 0) << law.index() << " at " << y;
      EXPECT_GE(at.slope, 0) << law.index() << " at " << y;
      EXPECT_GE(at.value, below) << law.index() << " at " << y;
      below = at.value;
    }
  }
}

TEST(NonlinearLaw, has_the_slope_of_its_value) {
  for (const ElementLaw& law : all_laws()) {
    // Beside the bends, which lie at whole sizes; as far as a diode's exponential goes.
    for (const double part : {-7.3, -1.2, -0.6, -0.01, 0.0, 0.4, 0.9, 1.1, 5.3, 30.1, 55.5}) {
      const double y = part * size_of(law);
      const double h = 1e-6 * size_of(law);
      const double slope =
          (evaluate_law(law, y + h, 10).value - evaluate_law(law, y - h, 10).value) / (2 * h);
      const double expected = evaluate_law(law, y, 10).slope;
      const double scale = std::abs(evaluate_law(law, y, 10).value) / size_of(law);
      EXPECT_NEAR(slope, expected, 1e-8 * (std::abs(expected) + scale) + 1e-22)
          << law.index() << " at " << y;  // 1e-6 squared, and rounding over 1e-6
    }
  }
}

TEST(NonlinearLaw, keeps_a_diode_finite_and_continuous_where_the_exponential_ends) {
  const Diode diode;
  const double end = 50 * diode.emission_voltage;
  const LawPoint before = evaluate_law(diode, end * (1 - 1e-12));
  const LawPoint after = evaluate_law(diode, end * (1 + 1e-12));
  EXPECT_NEAR(after.value / before.value, 1, 1e-9);  // 50 * 1e-12, amplified fifty times
  EXPECT_NEAR(after.slope / before.slope, 1, 1e-9);
  EXPECT_TRUE(std::isfinite(evaluate_law(diode, 1e6).value));
}

TEST(NonlinearLaw, holds_its_slope_within_one_percent_inside_the_range_and_not_beyond) {
  const double negligible = 1e-4;  // of a diode [S]
  const auto changed = [&](const ElementLaw& law, double from, double to) {
    const double a = evaluate_law(law, from).slope;
    const double b = evaluate_law(law, to).slope;
    const bool diode = std::holds_alternative<Diode>(law);
    const double floor = diode ? negligible : 0;
    return std::abs(b - a) > 0.01 * 1.0001 * std::max(std::abs(a), floor);
  };
  for (const ElementLaw& law : all_laws()) {
    if (std::holds_alternative<ThermalResistor>(law)) continue;  // a range of temperature
    for (const double at : {0.0, 0.3, 25.0}) {
      const double y = at * size_of(law);
      const ArgumentRange range = find_linear_range(law, y);
      EXPECT_LE(range.from, y);
      EXPECT_GE(range.to, y);
      const double step = 1e-3 * size_of(law);
      if (std::isfinite(range.to)) {
        EXPECT_FALSE(changed(law, y, range.to - 1e-6 * step)) << law.index() << " at " << y;
        EXPECT_TRUE(changed(law, y, range.to + step)) << law.index() << " at " << y;
      }
      if (std::isfinite(range.from)) {
        EXPECT_FALSE(changed(law, y, range.from + 1e-6 * step)) << law.index() << " at " << y;
        EXPECT_TRUE(changed(law, y, range.from - step)) << law.index() << " at " << y;
      }
    }
  }
}

TEST(NonlinearLaw, gives_a_winding_the_rises_between_which_its_resistance_stays) {
  const ThermalResistor winding{2, 0.004, 5, 10, 0};
  const ArgumentRange range = find_linear_range(winding, 40);
  const double now = evaluate_law(winding, 1, 40).slope;
  EXPECT_NEAR(evaluate_law(winding, 1, range.from).slope / now, 0.99, 1e-12);
  EXPECT_NEAR(evaluate_law(winding, 1, range.to).slope / now, 1.01, 1e-12);
}

TEST(NonlinearLaw, refuses_values_without_meaning_by_name) {
  const std::vector<ElementLaw> wrong{
      Diode{.saturation_current = 0},
      Diode{.saturation_current = 1e-14, .emission_voltage = -1},
      VoltageClamp{.voltage = 0, .resistance = 1},
      VoltageClamp{.voltage = 1, .resistance = 0},
      SaturatingConductance{.conductance = 1, .limit = -1},
      CurrentLimiter{.current = 0, .resistance = 1},
      LimitedVoltageControlledVoltageSource{NAN, 1, {}, {}},
      LimitedVoltageControlledCurrentSource{1, 0, {}, {}},
      ThermalResistor{1, 0.004, 0, 1, 0},
      ThermalResistor{1, 0.004, 1, 1, -250},  // no resistance left
      ConstantVoltageSource{NAN},
      ConstantCurrentSource{INFINITY},
  };
  for (const ElementLaw& law : wrong) {
    Network network;
    const NodeId node = network.add_node("node", Domain::electrical);
    try {
      network.add("the part", node, ground, law);
      ADD_FAILURE() << law.index();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_EQ(error.place(), "the part");
    }
  }
}

}  // namespace
}  // namespace gyrator
