#pragma once

#include "gyrator/sweeps/variation.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

inline constexpr const char* study_schema_name = "gyrator/study/1";

/// Which points of the varied values' space are computed.
enum class SamplingKind {
  grid,   ///< every combination
  sobol,  ///< the first N of the Sobol sequence
  random  ///< N, evenly distributed
};
std::string_view name_of(SamplingKind kind);

/// A sweep as asked for: a model, what varies in it, and the analysis of each.
struct SweepStudy {
  std::string file;        ///< of the study or of the model, as given, for messages
  std::string model_file;  ///< as it is opened
  std::string model_text;  ///< what stands in it
  std::vector<VariationText> vary;
  SamplingKind sampling = SamplingKind::grid;
  std::size_t samples = 0;  ///< of sobol and random
  std::uint64_t seed = 1;   ///< of random
  std::string analysis;
  std::optional<double> timeout_s;  ///< of one point
  bool keep_going = false;          ///< a failed point is recorded and the rest goes on
};

/// The study file as a table: reader, JSON Schema (schemas/study.schema.json) and manual.
const Member& study_format();

/// Whether a document says that it is a study, by its key "schema".
bool is_study(const nlohmann::json& document);

/// The study in a file, with its model's text; a model's path is relative to the file. Throws
/// bad_input for what is not as study_format says, and for a model that cannot be read.
SweepStudy load_study(const std::string& path);

/// The same from JSON, without its model: model_file is what stands in the study.
SweepStudy parse_study(const nlohmann::json& document, const std::string& file);

/// The same as a study file, with the model's name as it was given; without what only says how it
/// is run (timeout, keep_going).
nlohmann::json describe_study(const SweepStudy& study);

}  // namespace gyrator
