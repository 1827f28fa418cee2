#pragma once

#include "gyrator/amplifiers/device_register.hpp"

#include <vector>

namespace gyrator {

/// Neighbouring registers that one request reads.
struct RegisterBlock {
  RegisterTable table = RegisterTable::holding;
  int address = 0, count = 0;
  std::vector<const DeviceRegister*> places;  ///< in it
};

/// The fewest requests that read them all, in the order of tables and addresses: a block spans
/// holes of at most `max_hole` registers (bits) and has at most `max_read` registers, or 2000 bits.
std::vector<RegisterBlock> plan_blocks(std::vector<const DeviceRegister*> places, int max_read,
                                       int max_hole);

}  // namespace gyrator
