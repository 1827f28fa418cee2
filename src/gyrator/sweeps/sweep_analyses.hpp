#pragma once

#include "gyrator/studies/model_file.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// A number that an analysis gives at each point.
struct SweepOutput {
  std::string name;
  std::string unit;  ///< "1" for a pure number or a code
  std::string meaning;
};

/// What can be asked at each point of a sweep. One more is one more row of the list.
struct SweepAnalysis {
  std::string_view name;
  std::string_view summary;
  std::vector<SweepOutput> (*outputs)(Motion motion);
  /// In the outputs' order and units; from many threads at once. Infinite where nothing bounds.
  std::vector<double> (*compute)(const Model& model);
};
const std::vector<SweepAnalysis>& sweep_analyses();

/// Throws bad_input, with the nearest name, for an unknown one.
const SweepAnalysis& find_sweep_analysis(const std::string& name, const std::string& place);

}  // namespace gyrator
