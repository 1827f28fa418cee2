#include "gyrator/passivity/disk_proof.hpp"

#include "gyrator/controllers/controller.hpp"
#include "gyrator/passivity/aliased_disk.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"

#include <random>

#include <gtest/gtest.h>

#include "alias_sums.hpp"
#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

const Sampling prompt{Rational(1, 1000), Rational(0)};
const Sampling late{Rational(1, 1000), Rational(1, 1000)};
const Sampling part_late{Rational(1, 1000), Rational(37, 100000)};

DiskProof prove(const Device& device, const Sampling& sampling, const DiscreteStateSpace& law) {
  PortModel model(device);
  return prove_disk(model, sampling, law);
}

DiskProof prove_wall(const Device& device, double stiffness, double damping) {
  return prove(device, prompt, make_contact_law(VirtualWall{stiffness, damping}, 1e-3));
}

TEST(DiskProof, holds_just_below_the_limit_of_a_spring_damper_wall_and_is_refuted_just_above) {
  // Cases 1 and 2: K <= 2 (b - |B|)/T, the first at every frequency at once.
  const Device p3 = make_p3().device;
  for (const auto& [B, limit] : {std::pair(0.0, 1600.0), std::pair(0.4, 800.0)}) {
    EXPECT_EQ(prove_wall(p3, limit * (1 - 1e-4), B).outcome, ProofOutcome::proved) << B;
    EXPECT_EQ(prove_wall(p3, limit * (1 + 1e-4), B).outcome, ProofOutcome::violated) << B;
    EXPECT_NE(prove_wall(p3, limit, B).outcome, ProofOutcome::proved) << B;
  }
}

struct Judged {
  std::string name;
  Device device;
  Controller controller;
};

std::vector<Judged> make_judged() {
  const auto compliant = [](SensorLocation sensor) {
    return make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, sensor).device;
  };
  const VirtualWall wall{0, 1e-5};
  return {{"point mass", make_p3().device, VirtualWall{0, 0.2}},
          {"rc motor", make_rc_motor().device, wall},
          {"rc motor, slow amplifier", make_slow_rc_motor(300).device, wall},
          {"voltage drive", make_voltage_driven_motor(0.5).device, wall},
          {"compliant, sensor at port", compliant(SensorLocation::port), VirtualWall{0, 0.1}},
          {"compliant, sensor at motor", compliant(SensorLocation::motor), VirtualWall{0, 0.1}}};
}

TEST(DiskProof, bounds_the_margin_between_its_middles_from_below) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> within(-1, 1);
  for (Judged judged : make_judged()) {
    for (const Sampling& sampling : {prompt, late}) {
      StiffnessLimits limits(judged.device, sampling, judged.controller, FreeOperator{});
      auto& wall = std::get<VirtualWall>(judged.controller.law);
      const double limit = limits.find(Criterion::exact_disk, wall.damping).stiffness;
      ASSERT_GT(limit, 0) << judged.name;
      for (const double share : {0.3, 0.9, 0.99}) {
        wall.stiffness = share * limit;
        const DiscreteStateSpace law = make_contact_law(judged.controller, 1e-3);
        const DiskProof proof = prove(judged.device, sampling, law);
        ASSERT_EQ(proof.outcome, ProofOutcome::proved) << judged.name << " at " << share;
        EXPECT_LT(proof.intervals.size(), 300) << judged.name;
        AliasedDisk disk(judged.device, sampling);
        for (const auto& interval : proof.intervals) {
          for (int i = 0; i < 3; ++i) {
            const double t = within(engine) * interval.reach;
            const double omega = interval.omega + t;
            const double margin =
                disk.at(omega).damping_margin(law.response(std::polar(1.0, omega * 1e-3)));
            const double bound = interval.margin + interval.slope * t - interval.curvature * t * t;
            // The sums agree to 1e-6 of the radius (remainder-1), of a margin of order Re Z.
            const double rounding = 2e-6 * disk.model().at(omega).impedance.real();
            EXPECT_GE(margin, bound - rounding) << judged.name << " at " << omega;
            EXPECT_GE(bound, interval.lowest() - rounding) << judged.name << " at " << omega;
          }
        }
      }
    }
  }
}

struct TrueDisk {
  double omega = 0, damping = 0;
  PlainDisk disk;
};

// Densely, half of the frequencies evenly over the logarithm of three decades, half over the range.
std::vector<TrueDisk> sum_densely(const KnownDevice& known, const Sampling& sampling) {
  constexpr int points = 200;
  constexpr int terms = 2000;
  const double period = sampling.period.to_double();
  // What lies beyond is nearly constant; under a turning delay its centres cancel.
  const PortForm far = known.at(Complex(0, terms * 2 * pi / period));
  const double size = std::abs(far.sensor_path * far.actuation) / (2 * far.impedance.real());
  std::vector<TrueDisk> disks;
  for (int i = 1; i <= points; ++i) {
    const double share = static_cast<double>(i) / points;
    const double omega = pi / period * (i % 2 == 0 ? std::pow(1e-3, share) : share);
    disks.push_back({omega, known.at(Complex(0, omega)).impedance.real(),
                     sum_plainly(known, sampling, omega, terms, {0, size})});
  }
  return disks;
}

// Re Z (|1 + H c|^2 - |H r|^2), or more by rounding of its terms and of the plain sums.
double find_most_margin(const TrueDisk& at, Complex law) {
  constexpr double rounding = 1e-11;
  const double reach = std::abs(law) * at.disk.radius;
  const double away = std::abs(1.0 + law * at.disk.center);
  return at.damping * ((away - reach) * (away + reach) + rounding * (away * away + reach * reach));
}

TEST(DiskProof, under_a_delay_of_part_of_a_period_proves_only_what_is_true) {
  const auto compliant = [](SensorLocation sensor) {
    return make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, sensor);
  };
  const std::vector<std::pair<KnownDevice, double>> devices{
      {make_p3(), 0.2},
      {make_rc_motor(), 1e-5},
      {make_slow_rc_motor(300), 1e-5},
      {make_voltage_driven_motor(0.5), 1e-5},
      {compliant(SensorLocation::port), 0.1},
      {compliant(SensorLocation::motor), 0.1}};
  std::mt19937_64 engine(7);
  std::uniform_real_distribution<double> share(0.5, 1.5);
  int proved = 0;
  int refuted = 0;
  for (const auto& [known, damping] : devices) {
    for (const Rational& periods : {Rational(13, 100), Rational(1, 2), Rational(137, 100)}) {
      const Sampling sampling{Rational(1, 1000), periods / 1000};
      const Controller wall = VirtualWall{0, damping};
      StiffnessLimits limits(known.device, sampling, wall, FreeOperator{});
      const double limit = limits.find(Criterion::exact_disk, damping).stiffness;
      ASSERT_GT(limit, 0);
      const std::vector<TrueDisk> disks = sum_densely(known, sampling);
      for (const double of_limit : {share(engine), share(engine), 1 - 1e-4, 1 + 1e-4, 1 + 1e-2}) {
        const DiscreteStateSpace law =
            make_contact_law(VirtualWall{of_limit * limit, damping}, 1e-3);
        const bool is_proved = prove(known.device, sampling, law).outcome == ProofOutcome::proved;
        double least = std::numeric_limits<double>::infinity();
        for (const TrueDisk& at : disks) {
          least =
              std::min(least, find_most_margin(at, law.response(std::polar(1.0, at.omega * 1e-3))));
        }
        if (is_proved) {
          EXPECT_GT(least, 0) << of_limit << " of the limit, late by " << periods.to_double();
        }
        proved += is_proved ? 1 : 0;
        refuted += least < 0 ? 1 : 0;
      }
    }
  }
  // Both happen: it is a test of both sides.
  EXPECT_GT(proved, 20);
  EXPECT_GT(refuted, 20);
}

TEST(DiskProof, covers_every_frequency_up_to_nyquist) {
  for (const Sampling& sampling : {prompt, late, part_late}) {
    const DiskProof proof =
        prove(make_rc_motor().device, sampling, make_contact_law(VirtualWall{0.01, 1e-5}, 1e-3));
    ASSERT_EQ(proof.outcome, ProofOutcome::proved);
    double reached = pi / 1e-3;
    for (const auto& interval : proof.intervals) {
      EXPECT_NEAR(interval.omega + interval.reach, reached, 1e-12 * reached);
      reached = interval.omega - interval.reach;
    }
    EXPECT_NEAR(reached, proof.lowest_omega, 1e-9 * reached);
  }
}

// A spring with a resonance of its own: a dip of the margin about its frequency and nowhere else.
DiscreteStateSpace make_law_with_dip(double stiffness, double depth, double omega, double width,
                                     double period) {
  const double radius = std::exp(-width / 2 * period);
  const double angle = omega * period;
  DiscreteStateSpace law;
  law.A.resize(2, 2);
  law.A << 2 * radius * std::cos(angle), -radius * radius, 1, 0;
  law.B = Eigen::Vector2d(1, 0);
  law.C = Eigen::RowVector2d(1, 0);
  law.D = 0;
  // Its peak, turned the worst way: of size `depth`.
  const Complex peak = law.response(std::polar(1.0, angle));
  law.C *= depth / std::abs(peak);
  law.D = stiffness;
  return law;
}

// Lowest margin of P3 by [8.2], exact for its constant damping, b + b_v: finely about the dip, and
// its skirts up to Nyquist.
double scan_dip(const DiscreteStateSpace& law, double omega, double width, double period) {
  const auto margin = [&](double w) {
    const Complex z = std::polar(1.0, w * period);
    const double virtual_damping =
        period / (2 * (1 - std::cos(w * period))) * std::real((1.0 / z - 1.0) * law.response(z));
    return 0.8 + virtual_damping;
  };
  double lowest = 1e9;
  for (int i = -2000; i <= 2000; ++i)
    lowest = std::min(lowest, margin(omega + 2e-2 * i * width / 2));
  for (int i = 1; i <= 500; ++i) lowest = std::min(lowest, margin(pi / period * i / 500));
  for (int i = 1; i <= 200; ++i) {
    const double away = 20 * width * std::pow(1.05, i);
    for (const double w : {omega - away, omega + away}) {
      if (w > 0 && w < pi / period) lowest = std::min(lowest, margin(w));
    }
  }
  return lowest;
}

// Dips of 0.01 Hz, where the points of a grid are hertz apart.
TEST(DiskProof, meets_a_dip_of_a_hundredth_of_a_hertz_between_coarse_points) {
  constexpr double period = 1e-3;
  constexpr double width = 2 * pi * 0.01;
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> hertz(5, 490);
  for (int i = 0; i < 10; ++i) {
    const double omega = 2 * pi * hertz(engine);
    const auto margin_at = [&](double depth) {
      return scan_dip(make_law_with_dip(400, depth, omega, width, period), omega, width, period);
    };
    // Depth at which the dip touches zero; the spring alone leaves 0.6.
    double shallow = 0;
    double deep = 1e5;
    ASSERT_LT(margin_at(deep), 0);
    while (deep - shallow > 1e-4 * deep) {
      const double middle = (shallow + deep) / 2;
      (margin_at(middle) > 0 ? shallow : deep) = middle;
    }
    const Device p3 = make_p3().device;
    const DiskProof below =
        prove(p3, prompt, make_law_with_dip(400, 0.99 * shallow, omega, width, period));
    EXPECT_EQ(below.outcome, ProofOutcome::proved) << omega;
    const DiskProof above =
        prove(p3, prompt, make_law_with_dip(400, 1.01 * shallow, omega, width, period));
    EXPECT_EQ(above.outcome, ProofOutcome::violated) << omega;
    EXPECT_NEAR(above.omega, omega, 100 * width);
  }
}

TEST(DiskProof, meets_a_narrow_band_in_which_the_bare_device_supplies_energy) {
  // Fed back through two equal lags w_0, a damping g adds g Re 1/(1 + jw/w_0)^2, which is lowest at
  // w = sqrt(3) w_0: -g/8.
  const double b = RcParameters{}.b;
  for (const double share : {0.9999, 1.0001}) {
    Device device = make_slow_rc_motor(50).device;
    device.drive.damping = {BackEmfDamping{.damping = 8 * b * share,
                                           .resistance_estimate = 1.5,
                                           .inductance_estimate = 0.5e-3,
                                           .low_pass_hz = 50,
                                           .high_pass_hz = {}}};
    PortModel model(device);
    const DiskProof proof = prove_disk(model, prompt, DiscreteStateSpace{{}, {}, {}, 0});
    if (share < 1) {
      EXPECT_EQ(proof.outcome, ProofOutcome::proved);
      continue;
    }
    ASSERT_EQ(proof.outcome, ProofOutcome::violated);
    EXPECT_TRUE(proof.active);
    EXPECT_NEAR(proof.omega, std::sqrt(3) * 2 * pi * 50, 10);
    EXPECT_LE(model.at(proof.omega).impedance.real(), 0);
  }
}

}  // namespace
}  // namespace gyrator
