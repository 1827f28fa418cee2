#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/passivity/port_response.hpp"
#include "gyrator/two_port/virtual_impedance.hpp"

#include <complex>

namespace gyrator {

/// What the computer knows of the device's motion.
enum class Sensing {
  velocity,  ///< the velocity of the sampling instant, as the published two-ports have it
  position   ///< the position, whose difference over a step it takes: G v, half a step later
};
std::string_view name_of(Sensing sensing);

/// How what is computed reaches the device and knows its motion.
struct ComputedPath {
  double period = 1e-3;  ///< between commands, which are held [s]; 0 for continuous time
  double delay = 0;      ///< from the sample to the command's effect [s]
  double step = 1e-3;    ///< of the computed bodies: the period over the substeps [s]
  Integration integration = Integration::semi_implicit;
  Sensing sensing = Sensing::velocity;
  double tick = 1e-3;                        ///< of the loop around it, in which wrappers act [s]
  DiscreteStateSpace output = make_gain(1);  ///< linear wrappers on the command
};

/// The device at one frequency between its port and the computer, with P = G O e^(-jw t_d)
/// (hold, wrappers, delay), u = -P F of the computed effort F, and V = 1 or the hold over a step:
///   f_h = Z v_h + (A P) F,      w = (V S) v_h - (V M P) F                         (sampled-1)
/// w is the velocity that the computer works with; Z, A, S, M as in (port-1). Aliases are left out.
struct SampledPort {
  std::complex<double> impedance;  ///< Z
  std::complex<double> actuation;  ///< A P
  std::complex<double> sensing;    ///< V S
  std::complex<double> feedback;   ///< V M P; 0 where the port's own motion is sensed
};

SampledPort compute_sampled_port(PortModel& device, const ComputedPath& path, double omega);

}  // namespace gyrator
