#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// Any text, made safe inside an HTML element or a quoted attribute: markup characters as
/// entities, control characters as spaces, broken UTF-8 as '?'. Line breaks stay.
std::string html_escape(std::string_view text);

/// <p>text</p>, escaped.
std::string html_paragraph(std::string_view text);

/// A cell of a table; `look` is one of the page's classes: "", "number", "yes", "no".
struct HtmlCell {
  std::string text;
  std::string look = {};
};

/// A table with its headings (none: no heading row); every text is escaped. Scrolls sideways on a
/// narrow screen.
std::string html_table(const std::vector<std::string>& headings,
                       const std::vector<std::vector<HtmlCell>>& rows);

/// A figure with its caption. `svg` goes in as it is, the caption escaped.
std::string html_figure(const std::string& svg, const std::string& caption);

enum class PageScript {
  none,
  figures  ///< that of html_interactive_figure
};

/// The whole page around `body`, with style and script inside: nothing is loaded from anywhere,
/// and the page forbids the browser to do so, or to run any other script (Content-Security-Policy).
std::string html_page(const std::string& title, const std::string& body,
                      PageScript script = PageScript::none);

}  // namespace gyrator
