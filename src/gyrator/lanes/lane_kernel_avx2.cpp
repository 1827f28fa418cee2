#define LANE_NAMESPACE lane_avx2
#include "gyrator/lanes/lane_crossings.inl"
#include "gyrator/lanes/lane_kernel.inl"
