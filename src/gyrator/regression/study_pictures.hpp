#pragma once

#include "gyrator/plots/plot.hpp"
#include "gyrator/regression/study_check.hpp"
#include "gyrator/regression/study_runner.hpp"

#include <string>
#include <vector>

namespace gyrator {

/// One of the study's figures, drawn from its answers; published data as points. Throws bad_input,
/// naming the curve, for a path that the answers do not have, or lists of unequal length.
Figure make_study_figure(const RegressionStudy& study, const StudyFigure& figure,
                         const StudyAnswers& answers);

/// A sentence for each figure that cannot be drawn because a run gave no answer: "the figure
/// 'limits' is not drawn: limit (sampling.period = 0.001) gave no answer: exit code 2: …". Those of
/// runs that the filter left out are not told.
std::vector<std::string> list_undrawn_figures(const StudyAnswers& answers);

/// Refuses a folder in which write_study_results would write over what the study reads: the study,
/// its baseline and reference traces, a model, a file that a model names. To be asked before the
/// runs. Throws bad_input at "--output", naming the file.
void check_results_folder(const RegressionStudy& study, const std::string& folder,
                          const std::string& filter);

/// The study as one HTML page: what it shows, its figures (or why one is not drawn), and the table
/// of `study check`.
std::string write_study_page(const StudyAnswers& answers, const std::vector<CheckRow>& rows);

/// Writes into a folder, which is made where it is missing: each answer (RUN.json, or RUN.2.json
/// where it varies), the motion of `simulate` (.csv), each figure (.svg), report.html and, where
/// there are answers that `gyrator report` knows, results.html. Every file whole or not at all.
/// Returns their names. Throws bad_input for what cannot be written or drawn.
std::vector<std::string> write_study_results(const StudyAnswers& answers,
                                             const std::vector<CheckRow>& rows,
                                             const std::string& folder);

}  // namespace gyrator
