#include "gyrator/cosim/sampled_plant.hpp"
#include "gyrator/mechanics/plant.hpp"
#include "gyrator/passivity/aliased_disk.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

struct Loop {
  std::string name;
  KnownDevice known;
  Sampling sampling;
  bool touched_everywhere = false;  // the disk's rim, by a heavy inertia
};

std::vector<Loop> make_loops() {
  const Sampling prompt{Rational(1, 1000), Rational(0)};
  const Sampling late{Rational(1, 1000), Rational(13, 10000)};
  const Sampling whole{Rational(1, 2000), Rational(1, 2000)};
  const auto compliant = [](SensorLocation sensor) {
    return make_compliant(2e-5, 2e-4, {0.8, 1e-4, 1e-5}, sensor);
  };
  return {{"rc motor", make_rc_motor(), prompt},
          {"rc motor, 1.3 periods late", make_rc_motor(), late},
          {"rc motor, one period late", make_rc_motor(), whole},
          {"rc motor, ideal drive", make_rc_motor({}, true), prompt, true},
          {"rc motor, ideal drive, late", make_rc_motor({}, true), late},
          {"voltage drive", make_voltage_driven_motor(0.5), prompt},
          {"wave drive", make_wave_motor(), prompt},
          {"wave drive, 1.3 periods late", make_wave_motor(), late},
          {"wave drive, winding cancelled to a tenth", make_wave_motor({.R_c = 1.854}), prompt},
          {"compliant, sensor at port", compliant(SensorLocation::port), prompt},
          {"compliant, sensor at motor", compliant(SensorLocation::motor), prompt},
          {"compliant, sensor at motor, late", compliant(SensorLocation::motor), late}};
}

// Any mixture of inertia, damper and spring, at times with resonators below and above Nyquist.
MassSpringDamper make_operator(Random& random, double inertia, double period, bool heavy) {
  const double stiffness = inertia / (period * period);
  MassSpringDamper held_by;
  if (heavy) return {1e6 * inertia, 0, 0, {}};
  if (random.chance(0.7)) held_by.inertia = random.log_uniform(1e-2, 1e2) * inertia;
  if (random.chance(0.5)) held_by.damping = random.log_uniform(1e-4, 1) * inertia / period;
  if (random.chance(0.7)) held_by.stiffness = random.log_uniform(1e-4, 10) * stiffness;
  while (random.chance(0.5)) {
    held_by.resonators.push_back(
        {random.log_uniform(1e-2, 10) * inertia, random.log_uniform(1e-2, 10) * stiffness});
  }
  return held_by;
}

// y/u on the unit circle, C (zI - phi)^-1 (recent z^-m + late z^-(m+1)): no aliases are summed
// here.
struct LoopResponse {
  Complex value;
  double rounding = 0;
};

LoopResponse respond(const SampledPlant& plant, Complex z) {
  const Eigen::Index n = plant.phi.rows();
  const Eigen::MatrixXcd pencil = z * Eigen::MatrixXcd::Identity(n, n) - plant.phi.cast<Complex>();
  const Complex whole = std::pow(z, -static_cast<double>(plant.delay.whole));
  const Eigen::VectorXcd input =
      whole * (plant.recent.cast<Complex>() + plant.late.cast<Complex>() / z);
  const Eigen::VectorXcd x = pencil.partialPivLu().solve(input);
  // Backward error: the solution is that of a pencil off by a few hundred roundings, the matrix
  // exponential's. |C pencil^-1| (|pencil| |x|) bounds what this changes.
  const Eigen::VectorXcd sense = plant.sense.transpose().cast<Complex>();
  const Eigen::VectorXcd row = pencil.transpose().partialPivLu().solve(sense);
  const double moved = row.cwiseAbs().dot(pencil.cwiseAbs() * x.cwiseAbs());
  return {(plant.sense.cast<Complex>() * x)(0), 500 * 0x1p-52 * moved};
}

TEST(DiskSoundness, holds_the_true_loop_of_every_passive_operator) {
  Random random(11);
  constexpr int operators = 60;
  for (const Loop& loop : make_loops()) {
    const double period = loop.sampling.period.to_double();
    AliasedDisk disk(loop.known.device, loop.sampling);
    std::vector<DiskPoint> points;
    for (const double share :
         {0.003, 0.03, 0.1, 0.2, 0.31, 0.43, 0.55, 0.68, 0.8, 0.91, 0.97, 0.999}) {
      points.push_back(disk.at(share * pi / period));
    }
    std::vector<double> nearest_to_rim(points.size(), 0);
    double worst_rounding = 0;
    for (int i = 0; i < operators; ++i) {
      const MassSpringDamper held_by =
          make_operator(random, loop.known.device.mechanics.inertia, period, i == 0);
      const SampledPlant plant = sample_plant(
          build_plant(build_device_network(loop.known.device, held_by)), loop.sampling);
      for (std::size_t p = 0; p < points.size(); ++p) {
        const DiskPoint& point = points[p];
        const LoopResponse response = respond(plant, std::polar(1.0, point.omega * period));
        const double distance = std::abs(response.value - point.center);
        // 1e-9 of the radius for the disk's own sums.
        EXPECT_LE(distance, point.radius * (1 + 1e-9) + response.rounding)
            << loop.name << ", operator " << i << " at " << point.omega * period / pi
            << " of Nyquist";
        nearest_to_rim[p] = std::max(nearest_to_rim[p], distance / point.radius);
        worst_rounding = std::max(worst_rounding, response.rounding / point.radius);
      }
    }
    // The test means something: rounding is far below the radius, and some operator comes close to
    // the rim: at low frequency, where the aliases count for little, an inertia or spring; and at
    // every frequency a hand that holds the port still, where A = 1 puts the origin on the rim.
    EXPECT_LT(worst_rounding, 1e-6) << loop.name;
    EXPECT_GT(*std::max_element(nearest_to_rim.begin(), nearest_to_rim.end()), 0.999) << loop.name;
    if (loop.touched_everywhere) {
      EXPECT_GT(*std::min_element(nearest_to_rim.begin(), nearest_to_rim.end()), 0.999)
          << loop.name;
    }
  }
}

}  // namespace
}  // namespace gyrator
