#pragma once

#include "gyrator/mechanics/plant.hpp"

namespace gyrator {

// What build_plant() and build_moving_plant() have in common; not for other use.

/// The plant of a reduced network: motion, signals, energies and states of rest, with positions
/// appended as states where the network does not hold them. Of `device` in the linear case, of the
/// network with its laws cut out as ports otherwise. Throws numerical, naming the signal, where a
/// sensed or felt one would need the derivative of the command.
Plant assemble_plant(const DeviceNetwork& device, const NetworkEquations& equations,
                     const Reduction& reduction);

/// One more row and column of zeros at index `at`, for a state that takes no part in the energy.
Eigen::MatrixXd grow_form(const Eigen::MatrixXd& form, Eigen::Index at);

/// One more zero at the end, for a state that a signal does not depend on.
Eigen::RowVectorXd grow_row(const Eigen::RowVectorXd& row);

}  // namespace gyrator
