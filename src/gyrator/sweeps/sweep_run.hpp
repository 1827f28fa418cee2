#pragma once

#include "gyrator/sweeps/sweep_store.hpp"

#include <functional>
#include <memory>
#include <string>

namespace gyrator {

struct SweepRequest {
  std::string output;        ///< the result file, HDF5
  std::string command_line;  ///< kept in it
  int threads = 0;           ///< of this process; 0: all cores, and one where there are processes
  bool restart = false;      ///< throws away what an earlier run has kept
  bool quiet = true;         ///< no progress bar
};

struct SweepSummary {
  SweepCounts counts;
  std::size_t resumed = 0;         ///< points that an earlier run had computed
  std::string first_reason;        ///< of the first point that failed
  bool is_told_elsewhere = false;  ///< another process of the same run tells it
};

/// Runs the study that `prepare` lays out, on the cores of this machine or, started by mpirun, in
/// all processes, and writes its result whole; what was done is kept beside it in a journal on the
/// way, and what a journal has is not computed again. The numbers and the file's bytes do not
/// depend on who computes what.
/// Throws what `prepare` and SweepJournal throw; the error of the first point that fails unless the
/// study keeps going; interrupted, saying what is kept, on Ctrl-C.
SweepSummary run_study(const std::function<SweepPlan()>& prepare, const SweepRequest& request);

}  // namespace gyrator
