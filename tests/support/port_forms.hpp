#pragma once

#include "gyrator/passivity/port_response.hpp"

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator::testing {

using Complex = std::complex<double>;

/// A device's port written down by hand: f_h = Z v_p - A u, v_s = S v_p + M u.
struct PortForm {
  Complex impedance, actuation;
  Complex sensor_path = 1, blocked_motion = 0;
};

/// Ten points a decade from 0.01 Hz to 100 kHz.
inline std::vector<double> sweep_frequencies() {
  std::vector<double> frequencies;
  for (int i = 0; i <= 70; ++i) frequencies.push_back(0.01 * std::pow(10.0, i / 10.0));
  return frequencies;
}

/// The descriptor mixes J s of 1e-6 to 10 with resistances; its LU costs three or four digits.
inline constexpr double port_tolerance = 1e-9;

/// Compares all four responses of a device with the form, at every frequency of the sweep.
inline void expect_port(const Device& device, const std::function<PortForm(Complex)>& form,
                        const std::string& name = "") {
  for (const PortResponse& r : compute_port_response(device, sweep_frequencies())) {
    const PortForm expected = form({0, r.omega});
    const std::string at = name + " " + std::to_string(r.omega / (2 * std::numbers::pi)) + " Hz";
    const Complex Z = expected.impedance;
    EXPECT_LE(std::abs(r.impedance - Z), port_tolerance * std::abs(Z))
        << at << " Z " << r.impedance << " not " << Z;
    // Passivity reads the damping alone, however small beside J w: it is known to rounding of that.
    EXPECT_LE(std::abs(r.impedance.real() - Z.real()),
              port_tolerance * std::abs(Z.real()) + 1e-14 * std::abs(Z))
        << at << " Re Z " << r.impedance.real() << " not " << Z.real();
    const auto expect_near = [&](const char* what, Complex found, Complex wanted, double rounding) {
      EXPECT_LE(std::abs(found - wanted), port_tolerance * std::abs(wanted) + rounding)
          << at << " " << what << " " << found << " not " << wanted;
    };
    expect_near("A", r.actuation, expected.actuation, 0);
    expect_near("S", r.sensor_path, expected.sensor_path, 0);
    // A difference of mobilities: known to rounding of those.
    expect_near("M", r.blocked_motion, expected.blocked_motion,
                expected.blocked_motion == 0.0 ? 0 : 1e-14 / std::abs(Z));
  }
}

/// A first-order lag.
inline Complex lag(Complex s, double hz) {
  return 1.0 / (1.0 + s / (2 * std::numbers::pi * hz));
}

}  // namespace gyrator::testing
