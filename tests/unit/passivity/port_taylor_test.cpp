#include "gyrator/passivity/port_taylor.hpp"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/passivity_closed_forms.hpp"

namespace gyrator {
namespace {

using namespace passivity_tests;

constexpr int samples = 100;  // on either side of the middle

// Largest |q(t) - value - slope t| over curvature t^2 on a dense sampling of the reach, where what
// is over is more than rounding of the given size.
template <class Function>
double find_tightness(const TaylorModel& model, const Function& q, double rounding) {
  double tightest = 0;
  for (int i = -samples; i <= samples; ++i) {
    if (i == 0) continue;
    const double t = model.reach * i / samples;
    const double over = std::abs(q(t) - model.value - model.slope * t) - rounding;
    if (over <= 0) continue;
    tightest = std::max(tightest, over / (model.curvature * t * t));
  }
  return tightest;
}

struct Named {
  std::string name;
  KnownDevice known;
};

// The last one's two equal lags make its poles defective: it has no modes.
Device make_defective() {
  Device device = make_slow_rc_motor(50).device;
  device.drive.damping = {BackEmfDamping{.damping = 4e-4,
                                         .resistance_estimate = 1.5,
                                         .inductance_estimate = 0.5e-3,
                                         .low_pass_hz = 50,
                                         .high_pass_hz = {}}};
  return device;
}

std::vector<Named> list_devices() {
  const auto compliant = [](SensorLocation sensor) {
    return make_compliant(0.04, 0.8, {2e4, 0.3, 0.02}, sensor);
  };
  return {{"rc motor", make_rc_motor()},
          {"rc motor, slow amplifier", make_slow_rc_motor(300)},
          {"voltage drive", make_voltage_driven_motor(0.5)},
          {"wave drive", make_wave_motor()},
          {"compliant, sensor at port", compliant(SensorLocation::port)},
          {"compliant, sensor at motor", compliant(SensorLocation::motor)}};
}

TEST(PortTaylor, encloses_the_closed_forms_of_its_parts_over_the_whole_reach) {
  for (const Named& named : list_devices()) {
    PortModel model(named.known.device);
    int finite = 0;
    double tightest = 0;
    for (const double omega : {1.0, 30.0, 300.0, 860.0, 3e3, 2e4, 1e6}) {
      for (const double share : {1e-3, 0.03, 0.3, 0.9}) {
        const double reach = share * omega;
        const PortTaylor port = expand_port(model, omega, reach);
        const auto form = [&](double t) { return named.known.at(Complex(0, omega + t)); };
        const auto check = [&](const char* part, const TaylorModel& over, const auto& q,
                               double size) {
          EXPECT_EQ(over.reach, reach);
          if (!std::isfinite(over.curvature)) return;
          ++finite;
          // Modes give their sum with ten digits.
          const double tightness = find_tightness(over, q, 1e-10 * size);
          EXPECT_LE(tightness, 1 + 1e-9)
              << named.name << ": " << part << " at " << omega << " rad/s, reach " << reach;
          tightest = std::max(tightest, tightness);
        };
        check(
            "damping", port.damping, [&](double t) { return form(t).impedance.real(); },
            std::abs(port.damping.value));
        const auto path = [&](double t) { return form(t).sensor_path * form(t).actuation; };
        check("path", port.path, path, std::abs(path(0)));
        const auto blocked = [&](double t) { return form(t).blocked_motion; };
        check("blocked", port.blocked, blocked, std::abs(blocked(0)) + 1e-300);
      }
    }
    EXPECT_GT(finite, 30) << named.name;
    EXPECT_GT(tightest, 0.05) << named.name << ": a bound that says little";
  }
}

TEST(PortTaylor, encloses_a_device_without_modes) {
  PortModel model(make_defective());
  ASSERT_FALSE(model.modes());
  int finite = 0;
  for (const double omega : {1.0, 100.0, 544.0, 3e3}) {
    for (const double share : {1e-3, 0.01, 0.1}) {
      const PortTaylor port = expand_port(model, omega, share * omega);
      if (!std::isfinite(port.damping.curvature)) continue;
      ++finite;
      const auto damping = [&](double t) { return model.at(omega + t).impedance.real(); };
      const auto path = [&](double t) {
        const PortResponse r = model.at(omega + t);
        return r.sensor_path * r.actuation;
      };
      // Rounding of Re Z comes from the size of Z.
      const double size = std::abs(model.at(omega).impedance);
      EXPECT_LE(find_tightness(port.damping, damping, 1e-12 * size), 1 + 1e-9) << omega;
      EXPECT_LE(find_tightness(port.path, path, 1e-12 * std::abs(path(0))), 1 + 1e-9) << omega;
    }
  }
  EXPECT_GT(finite, 5);
}

// H = z^-n: one eigenvalue, n-fold and defective.
DiscreteStateSpace make_delay_chain(Eigen::Index n) {
  DiscreteStateSpace law;
  law.A = Eigen::MatrixXd::Zero(n, n);
  law.A.diagonal(-1).setOnes();
  law.B = Eigen::VectorXd::Unit(n, 0);
  law.C = Eigen::RowVectorXd::Unit(n, n - 1);
  law.D = 0;
  return law;
}

// Butterworth low-pass of order 4, bilinear with c = tan(w_c T/2): two sections of
// c^2 (1 + z^-1)^2/((1 + a c + c^2) + 2 (c^2 - 1) z^-1 + (1 - a c + c^2) z^-2).
struct Section {
  double gain, a1, a2;
};
std::array<Section, 2> make_butterworth_sections(double c) {
  const auto section = [c](double angle) {
    const double a = 2 * std::cos(angle);
    const double d = 1 + a * c + c * c;
    return Section{c * c / d, 2 * (c * c - 1) / d, (1 - a * c + c * c) / d};
  };
  return {section(pi / 8), section(3 * pi / 8)};
}
Complex respond(const std::array<Section, 2>& sections, Complex z) {
  Complex product = 1;
  for (const Section& s : sections) {
    const Complex one = 1.0 + 1.0 / z;
    product *= s.gain * one * one / (1.0 + s.a1 / z + s.a2 / (z * z));
  }
  return product;
}
DiscreteStateSpace make_state_space(const Section& s) {
  DiscreteStateSpace law;
  law.A.resize(2, 2);
  law.A << -s.a1, -s.a2, 1, 0;
  law.B = Eigen::Vector2d(1, 0);
  law.C = s.gain * Eigen::RowVector2d(2 - s.a1, 1 - s.a2);
  law.D = s.gain;
  return law;
}

template <class Function>
void expect_enclosed(const DiscreteStateSpace& law, const Function& closed_form,
                     const std::string& name) {
  constexpr double T = 1e-3;
  int finite = 0;
  for (const double share : {1e-3, 0.02, 0.05, 0.3, 0.7, 0.99}) {
    for (const double part : {1e-3, 0.01, 0.1}) {
      const double omega = share * pi / T;
      const double reach = part * omega;
      const TaylorModel over = expand_law(law, T, omega, reach);
      EXPECT_EQ(over.reach, reach);
      if (!std::isfinite(over.curvature)) continue;
      ++finite;
      const auto q = [&](double t) { return closed_form(std::polar(1.0, (omega + t) * T)); };
      // Double precision of a resolvent whose entries are some 100 times its response.
      EXPECT_LE(find_tightness(over, q, 1e-13 * (1 + std::abs(q(0)))), 1 + 1e-9)
          << name << " at " << share << " of Nyquist, reach " << part;
    }
  }
  EXPECT_GT(finite, 8) << name;
}

TEST(PortTaylor, encloses_a_law_that_is_a_chain_of_delays) {
  for (const int n : {1, 3, 8}) {
    expect_enclosed(
        make_delay_chain(n), [n](Complex z) { return std::pow(z, -n); },
        std::to_string(n) + " delays");
  }
}

TEST(PortTaylor, encloses_a_butterworth_law_about_its_corner) {
  const double corner = 0.05 * pi;  // w_c T
  const auto sections = make_butterworth_sections(std::tan(corner / 2));
  // 3 dB at the corner: the closed form is what it says.
  ASSERT_NEAR(std::abs(respond(sections, std::polar(1.0, corner))), std::sqrt(0.5), 1e-12);
  const DiscreteStateSpace law =
      in_series(make_state_space(sections[0]), make_state_space(sections[1]));
  expect_enclosed(
      law, [&](Complex z) { return respond(sections, z); }, "Butterworth");
}

}  // namespace
}  // namespace gyrator
