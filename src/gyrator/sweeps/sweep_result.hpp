#pragma once

#include "gyrator/documents/column_file.hpp"
#include "gyrator/sweeps/sweep_store.hpp"

#include <string>

namespace gyrator {

/// The result of a sweep, or what there is of one, as columns with units (docs/sweeps.md). The
/// points that are done, in order; all of them in a finished one.
struct SweepTable {
  ColumnFile file;
  std::vector<std::size_t> points;  ///< of the rows
  std::size_t size = 0;             ///< of the sweep
};

SweepTable make_sweep_table(const SweepPlan& plan, const SweepStore& store,
                            const std::string& command_line);

/// Writes it as HDF5, whole or not at all, and on the disk before it takes its name.
void write_sweep_file(const std::string& path, const SweepPlan& plan, const SweepStore& store,
                      const std::string& command_line);

/// A finished sweep (HDF5) or one under way (its journal). Throws bad_input for any other file.
SweepTable read_sweep(const std::string& path);

/// How the rows have ended.
SweepCounts count_rows(const SweepTable& table);

/// The rows as comma-separated values, names with units as in the file, texts quoted.
void write_sweep_csv(const std::string& path, const SweepTable& table);

/// A table for people: the varied values, outputs and status of at most `most_rows` rows, evenly
/// chosen.
std::string describe_sweep(const SweepTable& table, std::size_t most_rows);

}  // namespace gyrator
