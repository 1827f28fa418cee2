#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What the report says about one command's result, besides its figure.
struct ReportSection {
  std::string title;    ///< plain text
  std::string html;     ///< paragraphs and tables
  std::string caption;  ///< plain text: how to read the figure
};

/// The section for any result by its "command". Throws bad_input, listing the known commands, for
/// another one, and for missing keys.
ReportSection report_section(const nlohmann::json& result);

/// The result in one plain sentence for the top of the page; empty where it gives none.
std::string verdict_sentence(const nlohmann::json& result);

/// Whether the sentence is bad news: not passive, not settling.
bool is_bad_news(const nlohmann::json& result);

/// The finding in plain sentences: textbook limit, true limit, and the operator that shows it.
/// Empty where the two criteria agree or are not both there.
std::string finding_in_words(const nlohmann::json& passivity);

}  // namespace gyrator
