#pragma once

#include "gyrator/passivity/stiffness_limit.hpp"
#include "gyrator/plots/plot.hpp"
#include "gyrator/studies/model_file.hpp"
#include "gyrator/studies/report_sections.hpp"

#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

struct EnvelopeRequest {
  Criterion criterion = Criterion::exact_disk;
  std::vector<double> cutoff_hz;  ///< of filtered differences; empty: the model's own estimator
  /// Band [Hz]; by default from 1 Hz (a hundredth of Nyquist, if that is lower) to Nyquist.
  std::optional<double> from_hz, to_hz;
};

/// Extremes of the displayed |Z_cl| over frequency, over all walls (and cut-offs) that the
/// criterion calls passive (envelope-1), the walls that have them, and the areas; command
/// "zwidth-envelope". Throws bad_input at "--cutoff" and "--band" for what no estimator or envelope
/// can have, and for a model whose wall is not computed from the position, one sample to one
/// command.
nlohmann::json make_envelope_result(const Model& model, const EnvelopeRequest& request);

/// |Z| and |1/Z| over frequency, one beside the other: extremes, the band between, the bare device.
Figure envelope_figure(const nlohmann::json& result);

ReportSection envelope_section(const nlohmann::json& result);

}  // namespace gyrator
