#include "gyrator/plots/html.hpp"

#include "gyrator/documents/digest.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/plots/web_assets.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace gyrator {
namespace {

constexpr const char* style = R"(
:root { color-scheme: light; --ink: #1c1c1c; --soft: #5a5a5a; --line: #d9d9d9; --blue: #0072b2; --red: #b34700; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.2rem 1.2rem 4rem; max-width: 72rem; background: #fff;
       color: var(--ink); font: 16px/1.5 "DejaVu Sans", Verdana, system-ui, sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0.5rem 0 1rem; }
h2 { font-size: 1.25rem; margin: 2.6rem 0 0.6rem; padding-top: 0.8rem;
     border-top: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.4rem 0 0.4rem; }
p { max-width: 46rem; margin: 0.5rem 0; }
.verdict { font-size: 1.15rem; padding: 0.7rem 1rem; border-left: 6px solid var(--blue);
           background: #eef6fb; max-width: none; }
.verdict.bad { border-color: var(--red); background: #fdf3ec; }
.finding { border: 1px solid var(--line); border-radius: 6px; padding: 0.4rem 1.2rem 1rem;
           margin: 1.2rem 0; }
.finding h2 { border: 0; margin: 0; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; margin: 0.8rem 0; font-size: 0.9rem; }
th, td { text-align: left; vertical-align: top; padding: 0.35rem 0.9rem 0.35rem 0;
         border-bottom: 1px solid var(--line); }
th { color: var(--soft); font-weight: 600; }
td.number { white-space: nowrap; font-variant-numeric: tabular-nums; }
td.yes { color: var(--blue); font-weight: 600; }
td.no { color: var(--red); font-weight: 600; }
figure { margin: 1rem 0; }
figure svg { display: block; width: 100%; height: auto; min-width: 42rem; }
figcaption { color: var(--soft); font-size: 0.9rem; max-width: 46rem; margin-top: 0.4rem; }
pre { font: 0.82rem/1.45 "DejaVu Sans Mono", monospace; background: #f6f6f6; padding: 0.8rem;
      border-radius: 4px; white-space: pre-wrap; overflow-wrap: anywhere; }
footer { color: var(--soft); font-size: 0.85rem; margin-top: 3rem; }
@media (max-width: 46rem) {
  thead ~ tbody td:last-child:not(.number) { min-width: 14rem; }
}
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; }
  figure, table, .finding, .verdict { break-inside: avoid; }
  figure svg { min-width: 0; }
  h2, h3 { break-after: avoid; }
  .scroll { overflow: visible; }
}
)";

/// Bytes written as hexadecimal digits, as base64 (RFC 4648).
std::string base64_of_hex(const std::string& digits) {
  constexpr std::string_view letters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t at = 0; at < digits.size(); at += 6) {  // three bytes are four letters
    auto group = digits.substr(at, 6);
    const auto bytes = group.size() / 2;
    group.resize(6, '0');
    const auto bits = std::stoul(group, nullptr, 16);
    for (unsigned i = 0; i < 4; ++i)
      text += i <= bytes ? letters[bits >> (18U - 6U * i) & 63U] : '=';
  }
  return text;
}

}  // namespace

std::string html_escape(std::string_view text) {
  std::string escaped;
  for (std::size_t from = 0; from <= text.size();) {
    const auto end = std::min(text.find('\n', from), text.size());
    for (const char c : plain_text(text.substr(from, end - from))) {
      switch (c) {
        case '&':
          escaped += "&amp;";
          break;
        case '<':
          escaped += "&lt;";
          break;
        case '>':
          escaped += "&gt;";
          break;
        case '"':
          escaped += "&quot;";
          break;
        case '\'':
          escaped += "&#39;";
          break;
        default:
          escaped += c;
      }
    }
    if (end < text.size()) escaped += '\n';
    from = end + 1;
  }
  return escaped;
}

std::string html_paragraph(std::string_view text) {
  return "<p>" + html_escape(text) + "</p>\n";
}

std::string html_table(const std::vector<std::string>& headings,
                       const std::vector<std::vector<HtmlCell>>& rows) {
  std::string html = "<div class=\"scroll\"><table>\n";
  if (!headings.empty()) html += "<thead><tr>";
  for (const auto& heading : headings) html += "<th>" + html_escape(heading) + "</th>";
  if (!headings.empty()) html += "</tr></thead>\n";
  html += "<tbody>\n";
  for (const auto& row : rows) {
    html += "<tr>";
    for (const auto& cell : row)
      html += (cell.look.empty() ? "<td>" : "<td class=\"" + html_escape(cell.look) + "\">") +
              html_escape(cell.text) + "</td>";
    html += "</tr>\n";
  }
  return html + "</tbody>\n</table></div>\n";
}

std::string html_figure(const std::string& svg, const std::string& caption) {
  return "<figure>\n<div class=\"scroll\">" + svg + "</div>\n<figcaption>" + html_escape(caption) +
         "</figcaption>\n</figure>\n";
}

std::string html_page(const std::string& title, const std::string& body, PageScript script) {
  std::string policy = "default-src 'none'; style-src 'unsafe-inline'";
  std::string styles = style;
  std::string script_element;
  if (script == PageScript::figures) {
    styles += figure_style();
    // As CDATA, that the page is well-formed XML as well.
    const auto text = "//<![CDATA[\n" + figure_script() + "\n//]]>\n";
    policy += "; script-src 'sha256-" + base64_of_hex(compute_sha256(text)) + "'";
    script_element = "<script>" + text + "</script>\n";
  }
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}{}</body>\n</html>\n",
      policy, html_escape(title), styles, body, script_element);
}

}  // namespace gyrator
