#include "gyrator/circuits/nonlinear_law.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrator {
namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double linear_from = 50;        // v / V_e above which the exponential goes on as a line
constexpr double gmin = 1e-12;            // [S], as in SPICE
constexpr double leak_part = 1e-9;        // of the steepest slope
constexpr double same_slope = 0.01;       // what counts as the same slope
constexpr double hardly_conducts = 1e-4;  // [S]

LawPoint saturate(double slope, double limit, double y) {
  const double value = slope * y;
  if (std::abs(value) <= limit) return {value, slope};
  return {std::copysign(limit, value), 0};
}

// Zero between -edge and edge, with a slope beyond.
LawPoint dead_zone(double edge, double slope, double y) {
  if (std::abs(y) <= edge) return {0, 0};
  return {slope * (y - std::copysign(edge, y)), slope};
}

LawPoint evaluate(const Diode& d, double v, double) {
  const double x = v / d.emission_voltage;
  if (x > linear_from) {
    const double top = d.saturation_current * std::exp(linear_from);
    return {top * (1 + x - linear_from) - d.saturation_current, top / d.emission_voltage};
  }
  return {d.saturation_current * std::expm1(x),
          d.saturation_current / d.emission_voltage * std::exp(x)};
}
LawPoint evaluate(const VoltageClamp& c, double v, double) {
  return dead_zone(c.voltage, 1 / c.resistance, v);
}
LawPoint evaluate(const CurrentLimiter& c, double i, double) {
  return dead_zone(c.current, c.resistance, i);
}
LawPoint evaluate(const SaturatingConductance& s, double v, double) {
  return saturate(s.conductance, s.limit, v);
}
LawPoint evaluate(const LimitedVoltageControlledVoltageSource& s, double v, double) {
  return saturate(s.gain, s.limit, v);
}
LawPoint evaluate(const LimitedVoltageControlledCurrentSource& s, double v, double) {
  return saturate(s.transconductance, s.limit, v);
}
LawPoint evaluate(const ThermalResistor& t, double i, double rise) {
  const double resistance = t.resistance * (1 + t.temperature_coefficient * rise);
  return {resistance * i, resistance};
}
template <class Linear>
LawPoint evaluate(const Linear&, double, double) {
  throw Error(ErrorCode::bad_input, "law", "a linear law has no port of its own");
}

// Where a law with one bend at +-edge keeps the slope that it has at `at`.
ArgumentRange between_edges(double edge, double at) {
  if (std::abs(at) <= edge) return {-edge, edge};
  return at > 0 ? ArgumentRange{edge, infinite} : ArgumentRange{-infinite, -edge};
}

ArgumentRange linear_range(const Diode& d, double at) {
  const double slope = evaluate(d, at, 0).slope;
  const double change = same_slope * std::max(slope, hardly_conducts);
  const double unit = d.saturation_current / d.emission_voltage;
  const auto argument_of = [&](double s) { return d.emission_voltage * std::log(s / unit); };
  return {slope > change ? argument_of(slope - change) : -infinite, argument_of(slope + change)};
}
ArgumentRange linear_range(const ThermalResistor& t, double rise) {
  if (t.temperature_coefficient == 0) return {-infinite, infinite};
  const double change = same_slope * std::abs(rise + 1 / t.temperature_coefficient);
  return {rise - change, rise + change};
}

}  // namespace

bool is_nonlinear(const ElementLaw& law) {
  return std::holds_alternative<Diode>(law) || std::holds_alternative<VoltageClamp>(law) ||
         std::holds_alternative<SaturatingConductance>(law) ||
         std::holds_alternative<CurrentLimiter>(law) ||
         std::holds_alternative<LimitedVoltageControlledVoltageSource>(law) ||
         std::holds_alternative<LimitedVoltageControlledCurrentSource>(law) ||
         std::holds_alternative<ThermalResistor>(law);
}

bool is_piecewise_linear(const ElementLaw& law) {
  return is_nonlinear(law) && !std::holds_alternative<Diode>(law) &&
         !std::holds_alternative<ThermalResistor>(law);
}

LawKind kind_of(const ElementLaw& law) {
  if (std::holds_alternative<CurrentLimiter>(law) || std::holds_alternative<ThermalResistor>(law))
    return LawKind::resistance;
  if (std::holds_alternative<LimitedVoltageControlledVoltageSource>(law))
    return LawKind::voltage_source;
  if (std::holds_alternative<LimitedVoltageControlledCurrentSource>(law))
    return LawKind::current_source;
  return LawKind::conductance;
}

LawPoint evaluate_law(const ElementLaw& law, double argument, double rise) {
  return std::visit([&](const auto& e) { return evaluate(e, argument, rise); }, law);
}

NonlinearPort make_port(const Element& element) {
  NonlinearPort port{element.name, element.law};
  // A flat law's companion lies midway between its leak and its steepest slope: neither then drowns
  // the other in rounding.
  const auto flat = [&](double steepest, double edge) {
    port.steepest_slope = steepest;
    port.companion = std::sqrt(leak_part) * steepest;
    port.leak = leak_part * steepest;
    port.size = edge;
  };
  const auto saturating = [&](double slope, double limit) {
    port.steepest_slope = port.companion = slope;
    port.size = slope != 0 ? limit / std::abs(slope) : 1;
  };
  std::visit(
      Overloaded{
          [&](const Diode& e) {
            port.size = e.emission_voltage;
            port.companion = 1e-3;
            port.leak = gmin;
            port.steepest_slope = 10;  // some 0.3 A
          },
          [&](const VoltageClamp& e) { flat(1 / e.resistance, e.voltage); },
          [&](const CurrentLimiter& e) { flat(e.resistance, e.current); },
          [&](const SaturatingConductance& e) {
            saturating(e.conductance, e.limit);
            port.leak = leak_part * e.conductance;
          },
          [&](const LimitedVoltageControlledVoltageSource& e) { saturating(e.gain, e.limit); },
          [&](const LimitedVoltageControlledCurrentSource& e) {
            saturating(e.transconductance, e.limit);
          },
          [&](const ThermalResistor& e) {
            port.companion = port.steepest_slope =
                e.resistance * (1 + e.temperature_coefficient * e.initial_rise);
          },
          [](const auto&) {},
      },
      element.law);
  return port;
}

double limit_step(const ElementLaw& law, double from, double to) {
  const auto* diode = std::get_if<Diode>(&law);
  if (!diode) return to;
  const double unit = diode->emission_voltage;
  const double critical = unit * std::log(unit / (std::sqrt(2.0) * diode->saturation_current));
  if (to <= critical || std::abs(to - from) <= 2 * unit) return to;
  if (from <= 0) return unit * std::log(std::max(to / unit, 2.0));
  const double growth = 1 + (to - from) / unit;
  return growth > 0 ? from + unit * std::log(growth) : critical;
}

ArgumentRange find_linear_range(const ElementLaw& law, double at) {
  return std::visit(Overloaded{
                        [&](const Diode& e) { return linear_range(e, at); },
                        [&](const ThermalResistor& e) { return linear_range(e, at); },
                        [&](const VoltageClamp& e) { return between_edges(e.voltage, at); },
                        [&](const CurrentLimiter& e) { return between_edges(e.current, at); },
                        [&](const SaturatingConductance& e) {
                          return between_edges(e.limit / e.conductance, at);
                        },
                        [&](const LimitedVoltageControlledVoltageSource& e) {
                          return between_edges(e.limit / std::abs(e.gain), at);
                        },
                        [&](const LimitedVoltageControlledCurrentSource& e) {
                          return between_edges(e.limit / std::abs(e.transconductance), at);
                        },
                        [](const auto&) {
                          return ArgumentRange{-infinite, infinite};
                        },
                    },
                    law);
}

}  // namespace gyrator
