#define LANE_NAMESPACE lane_baseline
#include "gyrator/lanes/lane_crossings.inl"
#include "gyrator/lanes/lane_kernel.inl"
