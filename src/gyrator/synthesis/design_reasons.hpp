#pragma once

#include "gyrator/synthesis/design_study.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// Parts to be bought for a candidate.
int count_parts(const DesignSpec& spec, const DesignOption& option);

/// Best first: by the objective; those that are equal to the best of them to six digits by yield,
/// then fewer parts, then less apparent inertia.
void sort_designs(const DesignSpec& spec, std::vector<Design>& designs);

/// What these figures miss most; null where they keep every constraint. The stiffness only where
/// nothing else is missed: what misses another bound is not searched for stiffness.
const DesignConstraint* find_worst_missed(const DesignSpec& spec, const DesignFigures& figures);

/// What keeps a topology out of the answer, by the figures of the best that it can do.
std::string describe_miss(const DesignSpec& spec, const DesignFigures& figures);

/// Why `other` comes after `first`: how much worse it is in the objective, what stops it from being
/// better, and, where it is as good within a thousandth, in what else the two differ.
std::string describe_loss(const DesignSpec& spec, const Design& first, const Design& other);

}  // namespace gyrator
