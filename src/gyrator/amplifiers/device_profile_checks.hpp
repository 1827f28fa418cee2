#pragma once

#include "gyrator/amplifiers/device_profile.hpp"

#include <string>

namespace gyrator {

/// Throws bad_input at "FILE: /json/pointer" for the first thing in which a profile contradicts
/// itself (see load_device_profile). Register i stands at /registers/i.
void check_device_profile(const DeviceProfile& profile);

/// Limits, step, codes and bits of one register against its type.
void check_register(const DeviceRegister& place, const std::string& where);

}  // namespace gyrator
