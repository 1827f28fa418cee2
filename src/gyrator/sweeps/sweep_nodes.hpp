#pragma once

#include "gyrator/nodes/nodes.hpp"
#include "gyrator/sweeps/sweep_record.hpp"

namespace gyrator {

/// The part of process 0: hands out chunks to the others, records what they send, and computes on
/// `threads` threads itself. Afterwards, and where it throws since the journal cannot be written,
/// the processes are finished.
void lead_sweep(const SweepPlan& plan, Nodes& nodes, SweepQueue& queue, SweepRecord& record,
                int threads);

/// The part of every other process: computes what process 0 hands out, until it has no more.
void follow_sweep(const SweepPlan& plan, Nodes& nodes, int threads);

}  // namespace gyrator
