#include "gyrator/mechanics/stability.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/cosim/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

// Where a drive that cancels its winding or feeds back its back-EMF begins to oscillate by itself.

namespace gyrator {
namespace {

using testing::make_re25;

constexpr double pi = std::numbers::pi;
constexpr double K_t = 23.5e-3, R = 2.06, L = 0.238e-3, J = 1.07e-6, b = 1.2e-6;  // make_re25()
constexpr double alpha = copper_temperature_coefficient;
// A pole counts from 1e-9 of the fastest one on, 1e-4 rad/s here; an ohm too much is 1/(2 L) or
// more of it, 2100 rad/s.
constexpr double edge_tolerance = 1e-7;

Device make_voltage_driven(double R_o, std::vector<Damping> damping) {
  Device device = make_re25();
  device.drive.amplifier = VoltageAmplifier{.bandwidth_hz = {}, .output_resistance = R_o};
  device.drive.damping = std::move(damping);
  return device;
}

// Largest motion of the state in the last quarter of a run over that in its second one, everything
// excited and no command. Rates, not the state itself: positions rest wherever they are left.
double run_alone(const Device& device, const Operator& held_by, double seconds) {
  const Plant plant =
      build_plant(build_device_network(device, held_by, find_amplifier_gain(device)));
  const auto engine = make_engine(EngineKind::exact, plant, {});
  constexpr int steps = 256;
  const int segment = engine->prepare(seconds / steps);
  PlantState state;
  state.xi = Eigen::VectorXd::Ones(plant.states());
  std::array<double, 4> largest{};
  for (std::size_t i = 0; i < steps; ++i) {
    engine->advance(segment, 0, Eigen::Vector2d::Zero(), state);
    double& quarter = largest[4 * i / steps];
    quarter = std::max(quarter, (plant.A * state.xi).norm());
  }
  return largest[3] / largest[1];
}

// Stable at 0.999 and unstable at 1.001 of the edge, by the poles and by a run.
void expect_edge(const std::function<Device(double)>& make, const Operator& held_by, double edge,
                 double seconds, const std::string& name) {
  for (const double share : {0.999, 1.001}) {
    const Device device = make(share * edge);
    const auto pole =
        find_unstable_pole(build_device_network(device, held_by, find_amplifier_gain(device)));
    EXPECT_EQ(pole.has_value(), share > 1) << name << ": " << share << " of " << edge;
    const double growth = run_alone(device, held_by, seconds);
    const std::string where =
        name + ": a run at " + std::to_string(share) + " of " + std::to_string(edge);
    if (share > 1) {
      EXPECT_GT(growth, 1.01) << where;
    } else {
      EXPECT_LT(growth, 0.99) << where;
    }
  }
}

TEST(StabilityEdges, of_a_cancellation_with_the_port_clamped_are_the_loops_resistance) {
  // L i' = -(R + R_o - R_c) i. With a pole in the feedback, (L s + R + R_o)(1 + s/w) = R_c: a
  // quadratic with positive coefficients up to the same edge.
  for (const double R_o : {0.0, 0.7}) {
    for (const std::optional<double> hz : {std::optional<double>{}, {5e3}}) {
      const auto make = [&](double R_c) {
        return make_voltage_driven(R_o, {ResistanceCancellation{R_c, hz}});
      };
      const auto edges = find_stability_edges(make(1));
      ASSERT_TRUE(edges.has_value());
      EXPECT_NEAR(*edges->clamped.cancellation / (R + R_o), 1, edge_tolerance) << R_o;
      // (R_c - R)/L of 9 rad/s at least, slower with the pole: a second is enough.
      expect_edge(make, ClampedOperator{}, R + R_o, 1, "R_o " + std::to_string(R_o));
    }
  }
}

// J L s^2 + (J r + b L) s + b r + K_t^2 with r = R + R_o - R_c: r > -b L/J, and r > -K_t^2/b.
double least_resistance_free() {
  return std::max(-b * L / J, -K_t * K_t / b);
}

// With F = 1/(1 + s/w): (J s + b)(L/w s^2 + (L + R'/w) s + r) + K_t^2 (1 + s/w), R' = R + R_o;
// Routh on a_3 … a_0, a_2 a_1 > a_3 a_0 being linear in r.
double least_resistance_free(double R_loop, double w) {
  const double l = L + R_loop / w;
  const double a_3 = J * L / w, a_2 = J * l + b * L / w;
  const double rest = b * l + K_t * K_t / w;  // a_1 = J r + rest, a_0 = b r + K_t^2
  const double routh = (a_3 * K_t * K_t - a_2 * rest) / (a_2 * J - a_3 * b);
  return std::max({routh, -K_t * K_t / b, -rest / J});
}

TEST(StabilityEdges, of_a_cancellation_with_the_port_free_lie_beyond_by_what_the_motion_loses) {
  for (const double R_o : {0.0, 0.7}) {
    for (const std::optional<double> hz : {std::optional<double>{}, {5e3}, {100}}) {
      const double r = hz ? least_resistance_free(R + R_o, 2 * pi * *hz) : least_resistance_free();
      ASSERT_LT(r, 0);
      const double edge = R + R_o - r;
      const auto make = [&](double R_c) {
        return make_voltage_driven(R_o, {ResistanceCancellation{R_c, hz}});
      };
      const auto edges = find_stability_edges(make(1));
      EXPECT_NEAR(*edges->free.cancellation / edge, 1, edge_tolerance)
          << R_o << " " << hz.value_or(0);
      EXPECT_GT(*edges->free.cancellation, *edges->clamped.cancellation);
      expect_edge(make, FreeOperator{}, edge, 1, "free, R_o " + std::to_string(R_o));
    }
  }
}

TEST(StabilityEdges, of_a_cancellation_over_temperature_are_where_cold_copper_is_cancelled) {
  // R (1 + alpha rise) + R_o = R_c, in closed form; nothing bounds it in the heat.
  for (const double R_o : {0.0, 0.7}) {
    const double R_c = 0.9 * (R + R_o);
    const auto make = [&](double rise) {
      Device device = make_voltage_driven(R_o, {ResistanceCancellation{R_c, {}}});
      device.drive.motor->temperature_rise = rise;
      return device;
    };
    const auto edges = find_stability_edges(make(0));
    const double clamped = ((R_c - R_o) / R - 1) / alpha;
    ASSERT_TRUE(edges->clamped.coldest_rise.has_value());
    EXPECT_NEAR(*edges->clamped.coldest_rise / clamped, 1, edge_tolerance);
    EXPECT_FALSE(edges->clamped.hottest_rise.has_value());
    EXPECT_NEAR(*edges->free.coldest_rise / (clamped - b * L / J / R / alpha), 1, edge_tolerance);
    EXPECT_FALSE(edges->free.hottest_rise.has_value());
    expect_edge(make, ClampedOperator{}, clamped, 2, "cold");
  }
}

TEST(StabilityEdges, of_a_cancellation_that_exceeds_now_are_where_it_is) {
  Device device = make_voltage_driven(0, {ResistanceCancellation{1.9, {}}});
  device.drive.motor->temperature_rise = -40;
  const auto edges = find_stability_edges(device);
  EXPECT_EQ(*edges->clamped.coldest_rise, -40);
  EXPECT_EQ(*edges->clamped.hottest_rise, -40);
  // The cancellation's own edge is told all the same.
  EXPECT_NEAR(*edges->clamped.cancellation / (R * (1 - 40 * alpha)), 1, edge_tolerance);
}

// Back-EMF feedback d under a current amplifier, g = 1/K_t and kappa = d/K_t^2:
//   i (1 + s/w_a)(1 + s/w_l) + kappa (R alpha rise) i = 0      clamped, exact estimates otherwise
Device make_fed_back(double d, double rise, std::optional<double> amplifier_hz,
                     std::optional<double> low_pass_hz) {
  Device device = make_re25();
  device.drive.amplifier = CurrentAmplifier{.bandwidth_hz = amplifier_hz};
  device.drive.motor->temperature_rise = rise;
  device.drive.damping = {BackEmfDamping{d, R, L, low_pass_hz, {}}};
  return device;
}

TEST(StabilityEdges, of_back_emf_feedback_are_where_the_cold_winding_turns_its_sign) {
  constexpr double d = 1e-3, kappa = d / (K_t * K_t);
  const double edge = -1 / (kappa * R * alpha);
  ASSERT_GT(edge, -1 / alpha);
  for (const std::optional<double> amplifier_hz : {std::optional<double>{}, {2e3}}) {
    const auto make = [&](double rise) { return make_fed_back(d, rise, amplifier_hz, 300); };
    const auto edges = find_stability_edges(make(0));
    ASSERT_TRUE(edges.has_value());
    EXPECT_FALSE(edges->clamped.cancellation.has_value());
    ASSERT_TRUE(edges->clamped.coldest_rise.has_value());
    EXPECT_NEAR(*edges->clamped.coldest_rise / edge, 1, edge_tolerance);
    EXPECT_FALSE(edges->clamped.hottest_rise.has_value());
    expect_edge(make, ClampedOperator{}, edge, 1, "back-EMF");
    // Free: (J s + b)((1 + s/w_a)(1 + s/w_l) + n - 1) + d with n = 1 + kappa R alpha rise, Routh
    // linear in n again. The motion's lag makes the free port the worse one under two lags.
    const double p = amplifier_hz ? 1 / (2 * pi * *amplifier_hz * 2 * pi * 300) : 0;
    const double sum = 1 / (2 * pi * 300) + (amplifier_hz ? 1 / (2 * pi * *amplifier_hz) : 0);
    const double a_3 = J * p, a_2 = J * sum + b * p;
    const double n = (a_3 * d - a_2 * b * sum) / (J * J * sum);
    EXPECT_EQ(n > 0, amplifier_hz.has_value());
    const double free_edge = (n - 1) / (kappa * R * alpha);
    EXPECT_NEAR(*edges->free.coldest_rise / free_edge, 1, edge_tolerance);
    expect_edge(make, FreeOperator{}, free_edge, 1, "back-EMF, free");
  }
}

TEST(StabilityEdges, of_back_emf_feedback_through_two_lags_lie_in_the_heat_as_well) {
  // Under a voltage amplifier, g = R/K_t: a_3 s^3 + ... of
  //   (R' + L s)(1 + s/w_a)(1 + s/w_l) + g d/K_t (R' - R),   R' = R (1 + alpha rise)
  // a_2 a_1 = a_3 a_0 is a quadratic in R'.
  constexpr double d = 27e-3, kappa = R * d / (K_t * K_t);
  constexpr double w_a = 2 * pi * 300, w_l = 2 * pi * 200;
  const auto make = [&](double rise) {
    Device device = make_voltage_driven(0, {BackEmfDamping{d, R, L, w_l / (2 * pi), {}}});
    device.drive.amplifier = VoltageAmplifier{.bandwidth_hz = w_a / (2 * pi)};
    device.drive.motor->temperature_rise = rise;
    return device;
  };
  const double sum = 1 / w_a + 1 / w_l, product = 1 / (w_a * w_l);
  // a_3 = L product, a_2 = L sum + R' product, a_1 = L + R' sum, a_0 = R' + kappa (R' - R).
  const double A = product * sum;
  const double B = L * sum * sum + L * product - L * product * (1 + kappa);
  const double C = L * L * sum + L * product * kappa * R;
  const double root = std::sqrt(B * B - 4 * A * C);
  const double low = (-B - root) / (2 * A), high = (-B + root) / (2 * A);
  ASSERT_GT(low, R);
  const auto edges = find_stability_edges(make(0));
  const double hottest = (low / R - 1) / alpha;
  ASSERT_LT(hottest, hottest_rise);
  ASSERT_TRUE(edges->clamped.hottest_rise.has_value()) << low << " … " << high;
  EXPECT_NEAR(*edges->clamped.hottest_rise / hottest, 1, edge_tolerance);
  // Cold: a_0 = 0, R' = kappa R/(1 + kappa).
  const double coldest = (kappa / (1 + kappa) - 1) / alpha;
  EXPECT_NEAR(*edges->clamped.coldest_rise / coldest, 1, edge_tolerance);
  expect_edge(make, ClampedOperator{}, hottest, 4, "hot");
  expect_edge(make, ClampedOperator{}, coldest, 4, "cold");
}

TEST(StabilityEdges, are_asked_only_of_drives_that_have_them) {
  EXPECT_FALSE(find_stability_edges(make_re25()));
  EXPECT_FALSE(find_stability_edges(testing::make_rc_display()));
  EXPECT_FALSE(find_stability_edges(testing::make_p3()));
  EXPECT_TRUE(find_stability_edges(make_fed_back(1e-4, 0, {}, {})));
}

TEST(RequireStableDevice, names_the_cancellation_and_what_it_may_be) {
  const auto make = [](double R_c) {
    return make_voltage_driven(0, {EddyCurrentBrake{1e-5, true}, ResistanceCancellation{R_c, {}}});
  };
  EXPECT_NO_THROW(require_stable_device(make(0.999 * R)));
  try {
    require_stable_device(make(1.001 * R));
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_EQ(error.place(), "damping/1");
    for (const char* part : {"2.06206 ohm", "2.06 ohm", "clamped", "below"}) {
      EXPECT_NE(error.message().find(part), std::string::npos) << error.message();
    }
  }
}

}  // namespace
}  // namespace gyrator
