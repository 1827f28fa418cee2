#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// Writes one self-contained HTML page (no network, no script) about the commands' results.
///
/// It opens with the verdict in a sentence and, where a passivity result's textbook criterion
/// (frequency_dependent) and exact disk disagree, with both limits and the operator that shows
/// who is right. Then a section per result: tables, figures and how to read them; at the end the
/// models and the command lines that made it. Text from the user is escaped everywhere.
///
/// Throws bad_input for an empty list, for a "command" that the report does not know (the message
/// lists those it does) and for missing keys, naming the result by its entry in `names` (the files
/// they came from) or, without names, by its place in the list.
void write_report(const std::vector<nlohmann::json>& results, const std::string& path,
                  const std::vector<std::string>& names = {});

/// The page of write_report as text.
std::string report_as_html(const std::vector<nlohmann::json>& results,
                           const std::vector<std::string>& names = {});

}  // namespace gyrator
