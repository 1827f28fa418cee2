#pragma once

#include "gyrator/verification/certificate_check.hpp"

#include <initializer_list>
#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

// The parts of a certificate as plain structs. All throw bad_input with the field as place where
// one is missing, unknown, of another type, or a number is not finite; sizes that do not fit too.

/// The object at `place` has these members and no others.
void require_members(const nlohmann::json& object, const std::string& place,
                     std::initializer_list<const char*> names);
double read_number(const nlohmann::json& object, const std::string& place, const char* name);
std::string read_text(const nlohmann::json& object, const std::string& place, const char* name);

HeldDevice read_held_device(const nlohmann::json& device);
DiscreteStateSpace read_law(const nlohmann::json& loop, const std::string& place);
CertifiedLoop read_certified_loop(const nlohmann::json& loop, const std::string& place);
Refutation read_refutation(const nlohmann::json& loop, const std::string& place);

}  // namespace gyrator
