#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

// The integrating engines come to the exact one as their tolerance is made smaller.

namespace gyrator {
namespace {

const VirtualWall wall{.stiffness = 0.3, .damping = 1e-4};

TimeRun run(const Device& device, EngineKind engine, double tolerance) {
  SimulationOptions options;
  options.duration = Rational(1, 20);
  options.initial_velocity = 1;
  options.engine = engine;
  options.engine_options.relative_tolerance = tolerance;
  return simulate(build_plant(build_device_network(device, FreeOperator{})), {}, wall,
                  {Rational(1, 1000), Rational(3, 10000)}, options);
}

// Largest error of a column, against its largest value.
double find_error(const TimeRun& found, const TimeRun& exact, const char* column) {
  double worst = 0;
  double largest = 0;
  for (std::size_t k = 0; k < exact.trace.column(column).size(); ++k) {
    const double expected = exact.trace.column(column)[k];
    worst = std::max(worst, std::abs(found.trace.column(column)[k] - expected));
    largest = std::max(largest, std::abs(expected));
  }
  return worst / largest;
}

class Convergence : public ::testing::TestWithParam<EngineKind> {};

TEST_P(Convergence, error_follows_the_tolerance_down) {
  // A step's error is the tolerance; 100 segments of some ten steps add up to 1000 at worst.
  constexpr double steps = 1000;
  Device stiff = testing::make_rc_display();
  stiff.drive.motor->inductance = 5e-6;  // 0.8 us against segments of 0.7 ms
  for (const Device& device : {testing::make_rc_display(), stiff}) {
    const TimeRun exact = run(device, EngineKind::exact, 1e-9);
    for (const char* column : {"position", "velocity", "energy_dissipated"}) {
      double coarsest = 0;
      double finest = 0;
      for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
        const double error = find_error(run(device, GetParam(), tolerance), exact, column);
        EXPECT_LE(error, steps * tolerance) << column << " at " << tolerance;
        if (tolerance == 1e-4) coarsest = error;
        finest = error;
      }
      // Six decades of tolerance bring three at least, unless the coarsest is exact already.
      EXPECT_LE(finest, std::max(1e-3 * coarsest, 1e-11)) << column;
    }
  }
}

std::string name_engine(const ::testing::TestParamInfo<EngineKind>& engine) {
  return engine.param == EngineKind::cvode ? "cvode" : "odeint";
}
INSTANTIATE_TEST_SUITE_P(All, Convergence, ::testing::Values(EngineKind::cvode, EngineKind::odeint),
                         name_engine);

TEST(Convergence, a_sampled_wall_tends_to_the_continuous_one_in_first_order_of_the_period) {
  // The hold delays by T/2 on the mean, -K T/2 of damping: halving T halves the difference from a
  // real spring. P3 against 400 N/m: x = x_0 e^{-d t}(cos w t + d/w sin w t).
  constexpr double m = 0.04, b = 0.8, K = 400, d = b / (2 * m), t = 0.1;
  const double w = std::sqrt(K / m - d * d);
  const double real = std::exp(-d * t) * (std::cos(w * t) + d / w * std::sin(w * t));
  const Plant plant = build_plant(build_device_network(testing::make_p3(), FreeOperator{}));
  const auto error = [&](std::int64_t samples) {
    SimulationOptions options;
    options.duration = Rational(1, 10);
    options.initial_position = 1;
    const TimeRun r =
        simulate(plant, {}, VirtualWall{.stiffness = K}, {Rational(1, 10 * samples), 0}, options);
    return r.trace.column("position").back() - real;
  };
  for (const std::int64_t samples : {400, 1600}) {
    // The next term is K T/(2 b) of the first: 6 % and 1.5 %.
    EXPECT_NEAR(error(samples) / error(2 * samples), 2, 40.0 / static_cast<double>(samples));
  }
}

}  // namespace
}  // namespace gyrator
