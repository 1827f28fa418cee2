#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/mechanics/device.hpp"
#include "gyrator/verification/held_device.hpp"

namespace gyrator {

/// Largest pole of a loop u = -H y and the frequency at which it turns.
struct LoopPole {
  double magnitude = 0;     ///< per period
  double frequency_hz = 0;  ///< of the largest of them
};

/// Exact poles of the sampled loop with an operator at the port, built from the certificate's
/// device:
///   (port_inertia + m_o) dv/dt = -C_f x - D_fu u - (D_fv + b_o) v - k_o e - sum k_i e_i
///   de/dt = v,   de_i/dt = v - v_i,   m_i dv_i/dt = k_i e_i,   dy/dt = v_s           (vl-1)
/// with resonators (m_i, k_i) hung at the port. Matrix exponential by its series after halving the
/// step, squared back, in extended precision; every command under way is a state. Throws bad_input
/// for a delay of more than 500 periods.
LoopPole find_loop_pole(const HeldDevice& device, const Sampling& sampling,
                        const DiscreteStateSpace& law, const MassSpringDamper& held_by);

}  // namespace gyrator
