#pragma once

#include "gyrator/mechanics/device.hpp"

#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

// The device of a model in normal form (read_document with model_format()): what the file says of
// motor, amplifier, damping and mechanics.

/// `file` is where netlists are looked for, and for messages.
Drive make_drive(const nlohmann::json& model, const std::string& file);

/// The same circuit made of other parts, while whatever somebody sets stays as it was set for
/// `nominal`: the winding's resistance in `fraction` and in the estimates that are left out, K_t in
/// the gain of back_emf, the resistor of a wave drive. Netlists are taken from `nominal`.
///   back_emf  -d/K_t0 e                          d' = d K_t/K_t0                         (tol-1)
///   wave      r = K_t0^2/b_w - R_out0            b_w' = K_t^2/(r + R_out)                (tol-2)
/// K_t0, R_out0 nominal; d, b_w as the model has them; d', b_w' what the drive then has.
Drive make_drive(const nlohmann::json& model, const Drive& nominal);

Mechanics make_mechanics(const nlohmann::json& mechanics);

}  // namespace gyrator
