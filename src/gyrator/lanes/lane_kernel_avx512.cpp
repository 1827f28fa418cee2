#define LANE_NAMESPACE lane_avx512
#include "gyrator/lanes/lane_crossings.inl"
#include "gyrator/lanes/lane_kernel.inl"
