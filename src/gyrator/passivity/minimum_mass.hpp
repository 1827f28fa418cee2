#pragma once

#include "gyrator/passivity/verdict.hpp"

#include <optional>

namespace gyrator {

/// Smallest mass of the simulated tool with which a virtual coupling is passive [kg, kg.m^2]: the
/// exact disk holds for every larger one too, with the tool free and, if it meets a wall, in
/// contact. 0 where every mass down to a millionth of K_c T^2 + B_c T is; none where not even a
/// very heavy tool is, because the coupling as a wall is not passive on this device, or because the
/// scheme makes energy at every mass.
/// Throws bad_input for a controller that is no virtual coupling, or one at a rate of its own.
/// Source: the question is that of Brown and Colgate 1998, [8.5.1]; answered here by (disk-2).
std::optional<double> find_minimum_mass(const PassivityModel& model, Integration integration);

}  // namespace gyrator
