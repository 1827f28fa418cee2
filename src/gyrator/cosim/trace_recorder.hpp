#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/cosim/engine.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// Columns of equal length. Row k is sample instant k: the state before the command jumps, the
/// command computed there, and in columns "..._after" what the jump of the held command changes at
/// that instant. With a trace step, rows in between too, and two rows where the hold jumps.
struct Trace {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;

  const std::vector<double>& column(const std::string& name) const;
};

/// What the loop knows of a row beside the plant's state.
struct TraceRow {
  double time = 0, measured = 0;
  double command = 0;     ///< asked for by the controller
  double held_after = 0;  ///< after the jump at this instant
};

/// Writes the rows of a run.
class TraceRecorder {
 public:
  struct Options {
    bool ledger = true;
    bool external_effort = false;  ///< a column of its own
  };
  /// All but the options must outlive the recorder.
  TraceRecorder(const Plant& plant, Engine& engine, const RunningController& controller,
                Trace& trace, Options options);

  void reserve(std::size_t rows);
  /// Bytes of a row.
  double row_size() const;
  /// A row with the held inputs u = [command; external effort].
  void record(const TraceRow& row, const Eigen::Vector2d& u, const PlantState& state);
  /// Energy stored under the held inputs [J].
  double stored(const Eigen::Vector2d& u, const PlantState& state);

 private:
  bool jumps(const Signal& signal) const;
  double stored_under(const Eigen::VectorXd& inputs, const PlantState& state);

  const Plant& plant_;
  Engine& engine_;
  const RunningController& controller_;
  Trace& trace_;
  Options options_;
  std::vector<const Signal*> jumping_;  // with the command, each with a column "..._after"
  Eigen::VectorXd z_, gradient_, before_;
  std::vector<double> told_;  // by the controller
};

}  // namespace gyrator
