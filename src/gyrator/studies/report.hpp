#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// Writes one self-contained HTML page (no network) about the commands' results, with figures to
/// zoom and to ask for values where a script may run, and pictures of the same in print.
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

/// Writes the page's figures as SVG files into `folder`, which is made where it is missing, and
/// returns their paths: device.svg, finding.svg and, by place and command, 1-passivity.svg, ….
/// Errors as for write_report, and bad_input where the folder cannot be made or written.
std::vector<std::string> write_report_figures(const std::vector<nlohmann::json>& results,
                                              const std::string& folder,
                                              const std::vector<std::string>& names = {});

}  // namespace gyrator
