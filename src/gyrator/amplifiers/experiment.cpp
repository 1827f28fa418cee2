#include "gyrator/amplifiers/experiment.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr int prbs_length = (1 << 15) - 1;

// x^15 + x^14 + 1, from all ones.
const std::array<bool, prbs_length>& prbs_bits() {
  static const std::array<bool, prbs_length> bits = [] {
    std::array<bool, prbs_length> made{};
    std::uint16_t shift = 0x7fff;
    for (bool& bit : made) {
      bit = (shift & 1) != 0;
      const unsigned feedback = (shift ^ (shift >> 1)) & 1U;
      shift = static_cast<std::uint16_t>((shift >> 1) | (feedback << 14));
    }
    return made;
  }();
  return bits;
}

}  // namespace

std::string_view name_of(DriveMode mode) {
  return mode == DriveMode::current ? "current" : "voltage";
}

std::string_view unit_of(DriveMode mode) {
  return mode == DriveMode::current ? "A" : "V";
}

std::string_view name_of(ExcitationKind kind) {
  switch (kind) {
    case ExcitationKind::dc:
      return "dc";
    case ExcitationKind::step:
      return "step";
    case ExcitationKind::sine:
      return "sine";
    case ExcitationKind::chirp:
      return "chirp";
    case ExcitationKind::prbs:
      return "prbs";
  }
  return "";
}

double compute_command(const Excitation& excitation, double t) {
  const auto& [kind, mode, a, o, f, f_end, d] = excitation;
  if (t < 0 || t >= d) return 0;
  switch (kind) {
    case ExcitationKind::dc:
      return o;
    case ExcitationKind::step:
      return t < d / 4 ? o : o + a;
    case ExcitationKind::sine:
      return o + a * std::sin(2 * std::numbers::pi * f * t);
    case ExcitationKind::chirp:
      return o + a * std::sin(2 * std::numbers::pi * (f * t + (f_end - f) * t * t / (2 * d)));
    case ExcitationKind::prbs: {
      // Instants are multiples of a tick: a bit that begins at one must not depend on rounding.
      const auto bit = static_cast<std::int64_t>(std::floor(t * f + 1e-9));
      return prbs_bits()[static_cast<std::size_t>(bit % prbs_length)] ? o + a : o - a;
    }
  }
  return 0;
}

double find_peak(const Excitation& excitation) {
  switch (excitation.kind) {
    case ExcitationKind::dc:
      return std::abs(excitation.offset);
    case ExcitationKind::step:
      return std::max(std::abs(excitation.offset),
                      std::abs(excitation.offset + excitation.amplitude));
    default:
      return std::abs(excitation.offset) + std::abs(excitation.amplitude);
  }
}

std::string describe(const Excitation& excitation) {
  const auto& [kind, mode, a, o, f, f_end, d] = excitation;
  const std::string_view unit = unit_of(mode);
  switch (kind) {
    case ExcitationKind::dc:
      return fmt::format("dc of {:.4g} {} for {:.4g} s", o, unit, d);
    case ExcitationKind::step:
      return fmt::format("step from {:.4g} to {:.4g} {}, {:.4g} s", o, o + a, unit, d);
    case ExcitationKind::sine:
      return fmt::format("sine of {:.4g} {} about {:.4g} {}, {:.4g} Hz, {:.4g} s", a, unit, o, unit,
                         f, d);
    case ExcitationKind::chirp:
      return fmt::format("chirp of {:.4g} {} about {:.4g} {}, {:.4g} to {:.4g} Hz, {:.4g} s", a,
                         unit, o, unit, f, f_end, d);
    case ExcitationKind::prbs:
      return fmt::format("prbs of {:.4g} {} about {:.4g} {}, {:.4g} bit/s, {:.4g} s", a, unit, o,
                         unit, f, d);
  }
  return {};
}

void check_excitation(const Excitation& excitation) {
  const auto& [kind, mode, a, o, f, f_end, d] = excitation;
  const auto refuse = [](const std::string& message) {
    throw Error(ErrorCode::bad_input, "excitation", message);
  };
  for (const double value : {a, o, f, f_end, d})
    if (!std::isfinite(value)) refuse("a value that is not finite");
  if (!(d > 0)) refuse(fmt::format("a duration of {:.6g} s: must be above 0 s", d));
  const bool has_frequency = kind != ExcitationKind::dc && kind != ExcitationKind::step;
  if (has_frequency && !(f > 0))
    refuse(fmt::format("a frequency of {:.6g} Hz: must be above 0 Hz", f));
  if (kind == ExcitationKind::chirp && !(f_end > 0))
    refuse(fmt::format("an end frequency of {:.6g} Hz: must be above 0 Hz", f_end));
}

}  // namespace gyrator
