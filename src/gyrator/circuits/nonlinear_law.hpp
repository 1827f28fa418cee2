#pragma once

#include "gyrator/circuits/network.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// Whether a law's slope depends on its argument (or on a temperature).
bool is_nonlinear(const ElementLaw& law);

/// Whether a nonlinear law consists of lines: one slope up to +-edge, another beyond.
bool is_piecewise_linear(const ElementLaw& law);

/// What a nonlinear law is a function of, and what it gives.
enum class LawKind {
  conductance,     ///< i over the element's own v
  resistance,      ///< v over the element's own i, which is an unknown of its own
  voltage_source,  ///< v over a control voltage
  current_source   ///< i over a control voltage
};
LawKind kind_of(const ElementLaw& law);

/// Value of a law and its slope at an argument.
struct LawPoint {
  double value = 0, slope = 0;
};
/// `rise` [K] is for ThermalResistor alone. Throws bad_input for a linear law.
LawPoint evaluate_law(const ElementLaw& law, double argument, double rise = 0);

/// A nonlinear element cut out of the network: the network keeps `companion` y and gets what is
/// left of the law as an input,
///   w = law(y) + leak y - companion y.                                            (port-1)
/// The leak stands beside flat laws, as gmin does in SPICE, so that a node between them and
/// inductors keeps a voltage: 1e-12 S for a diode, 1e-9 of the steepest slope for clamps, limiters
/// and brakes. The linear tools leave it out.
struct NonlinearPort {
  std::string element;
  ElementLaw law;
  double companion = 0, leak = 0;
  double size = 1;  ///< argument at which the law bends: the edge of a piecewise linear one
  double steepest_slope = 0;  ///< anywhere it is likely to be used
};
NonlinearPort make_port(const Element& element);

/// Shortens a Newton step to `to` where the law grows exponentially (SPICE's pnjlim; Nagel 1975).
double limit_step(const ElementLaw& law, double from, double to);

/// Arguments around `at` between which the slope stays within 1 %: of itself; of the steepest slope
/// where it is flat; of 0.1 mS for a diode that hardly conducts. For a ThermalResistor, rises [K].
struct ArgumentRange {
  double from = 0, to = 0;
};
ArgumentRange find_linear_range(const ElementLaw& law, double at);

}  // namespace gyrator
