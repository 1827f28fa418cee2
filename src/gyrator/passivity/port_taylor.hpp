#pragma once

#include "gyrator/controllers/discrete_state_space.hpp"
#include "gyrator/passivity/port_response.hpp"
#include "gyrator/passivity/taylor_model.hpp"

#include <vector>

namespace gyrator {

/// (port-1) over an interval of frequencies, as far as the aliased disk needs it.
struct PortTaylor {
  TaylorModel damping;  ///< Re Z
  TaylorModel path;     ///< S A
  TaylorModel blocked;  ///< M
};

/// (port-1) for |w - omega| <= reach, omega > reach >= 0 [rad/s]: from the device's modes,
///   1/(jw - p) = u - j u^2 t + …,  u = 1/(j omega - p),  remainder <= |u|^3 t^2/(1 - |u| reach),
/// or, where it has none, from its resolvent (expand_response).
PortTaylor expand_port(PortModel& model, double omega, double reach);

/// H(e^(jwT)) for |w - omega| <= reach. Law's states of any kind, defective ones included.
TaylorModel expand_law(const DiscreteStateSpace& law, double period, double omega, double reach);

/// The entries, row by row, of G(s) = C (sI - A)^-1 B + D where s moves by d, |d - turn t| <=
/// bend t^2 and |d| <= |speed| |t|:
///   G(s + d) = G - d C R^2 B + d^2 C R^2 (I + d R)^-1 R B,  R = (sI - A)^-1 (resolvent-1)
/// the last term bounded by absolute values, entry by entry.
std::vector<TaylorModel> expand_response(const StateSpace& system, std::complex<double> s,
                                         std::complex<double> turn, double bend, double speed,
                                         double reach);

}  // namespace gyrator
