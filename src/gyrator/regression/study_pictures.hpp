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

/// The study as one HTML page: what it shows, its figures, and the table of `study check`.
std::string write_study_page(const StudyAnswers& answers, const std::vector<CheckRow>& rows);

/// Writes into a folder, which is made where it is missing: each answer (RUN.json, or RUN.2.json
/// where it varies), the motion of `simulate` (.csv), each figure (.svg), report.html and, where
/// there are answers that `gyrator report` knows, results.html. Every file whole or not at all.
/// Returns their names. Throws bad_input for what cannot be written or drawn.
std::vector<std::string> write_study_results(const StudyAnswers& answers,
                                             const std::vector<CheckRow>& rows,
                                             const std::string& folder);

}  // namespace gyrator
