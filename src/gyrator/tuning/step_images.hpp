#pragma once

#include "gyrator/mechanics/device.hpp"
#include "gyrator/tuning/drive_response.hpp"

namespace gyrator {

/// A sine whose command was held from tick to tick, as if it had been continuous.
///
/// The generator's steps have images of the sine around every multiple of their rate, and samples
/// fold these onto it: up to a sixth of the terminal voltage of an inductive winding at 400 Hz with
/// ticks of 0.1 ms, a percent of the current. Each signal is multiplied by what the model of the
/// drive says of it,
///   F = c (sI - A)^-1 b h(s) e^(-s d) / [c (zI - phi)^-1 (late z^-(m+1) + recent z^-m)]  (image-1)
/// h the hold over a `tick` [s], d the amplifier's `delay` [s], phi, late and recent of (smp-1)
/// over a tick; and the command by h, so that it is the fundamental of what was played.
///
/// `device` is the drive with the settings of the measurement, behind an amplifier of finite
/// bandwidth; without one no signal but the command is changed.
Tone remove_step_images(const Tone& tone, const Device& device, double tick, double delay);

}  // namespace gyrator
