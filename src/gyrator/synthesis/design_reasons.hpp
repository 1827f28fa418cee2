#pragma once

#include "gyrator/synthesis/design_study.hpp"

#include <string>

namespace gyrator {

/// Parts to be bought for a candidate.
int count_parts(const DesignSpec& spec, const DesignOption& option);

/// Whether `a` goes before `b`: by the objective; where that is equal to six digits by yield, then
/// fewer parts, then less apparent inertia.
bool goes_before(const DesignSpec& spec, const Design& a, const Design& b);

/// Why `other` comes after `first`: how much worse it is in the objective, what stops it from being
/// better, and, where it is as good within a thousandth, in what else the two differ.
std::string describe_loss(const DesignSpec& spec, const Design& first, const Design& other);

}  // namespace gyrator
