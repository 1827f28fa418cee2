#include "gyrator/plots/plot.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/plots/gnuplot.hpp"
#include "gyrator/plots/html.hpp"
#include "gyrator/plots/plot_script.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string>
#include <string_view>

namespace gyrator {
namespace {

PlotFormat format_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".svg") return PlotFormat::svg_file;
  if (extension == ".png") return PlotFormat::png;
  throw Error(ErrorCode::bad_input, path,
              "a figure's name must end in .svg or .png" +
                  (extension.empty() ? std::string() : ", not " + extension));
}

void check_id(const std::string& id) {
  const auto letter = [](unsigned char c) { return c < 0x80 && std::isalpha(c) != 0; };
  const auto allowed = [](unsigned char c) {
    return c < 0x80 && (std::isalnum(c) != 0 || c == '_');
  };
  if (id.empty() || !letter(static_cast<unsigned char>(id.front())) ||
      !std::all_of(id.begin(), id.end(), allowed))
    throw Error(ErrorCode::bad_input, "figure",
                "id \"" + id + "\": must be letters, digits and '_', a letter first");
}

/// gnuplot's markers and filters have the same ids in every picture; here each id, and each
/// reference to one, gets `id` before it. Only inside tags: text may hold the same letters.
std::string with_own_ids(std::string_view svg, const std::string& id) {
  constexpr std::array<std::string_view, 5> before_ids = {" id='", " id=\"", "href='#", "href=\"#",
                                                          "url(#"};
  std::string result;
  result.reserve(svg.size() + svg.size() / 8);
  bool in_tag = false;
  while (!svg.empty()) {
    if (svg.front() == '<') in_tag = true;
    if (svg.front() == '>') in_tag = false;
    const auto* found =
        !in_tag ? before_ids.end()
                : std::find_if(before_ids.begin(), before_ids.end(),
                               [&](std::string_view lead) { return svg.starts_with(lead); });
    if (found == before_ids.end()) {
      result += svg.front();
      svg.remove_prefix(1);
      continue;
    }
    result += *found;
    svg.remove_prefix(found->size());
    if (!svg.starts_with(id + "_plot_")) result += id + "_";  // gnuplot's own `name` did the others
  }
  return result;
}

/// gnuplot calls the picture by its id; readers of the page had rather hear its title.
void set_picture_title(std::string& svg, const std::string& id, const std::string& title) {
  const std::string given = "<title>" + id + "</title>";
  const auto at = svg.find(given);
  if (at != std::string::npos)
    svg.replace(at, given.size(), title.empty() ? "" : "<title>" + html_escape(title) + "</title>");
}

/// Takes out gnuplot's tool tips "figure_plot_3" of curves without a title.
void remove_empty_titles(std::string& svg, const std::string& id) {
  const std::string lead = "<title>" + id + "_plot_";
  for (auto at = svg.find(lead); at != std::string::npos; at = svg.find(lead, at))
    svg.erase(at, svg.find("</title>", at) + 8 - at);
}

}  // namespace

void render_figure(const Figure& figure, const std::string& path) {
  const auto format = format_of(path);
  auto picture = run_gnuplot(gnuplot_script(figure, format, "figure"));
  if (format == PlotFormat::svg_file) {
    remove_empty_titles(picture, "figure");
    set_picture_title(picture, "figure", figure.title);
  }
  write_text_file(path, picture);
}

std::string figure_as_svg(const Figure& figure, const std::string& id) {
  check_id(id);
  auto svg = run_gnuplot(gnuplot_script(figure, PlotFormat::svg_embedded, id));
  svg.erase(0, svg.find("<svg"));  // the prologue belongs to a file of its own
  // On a wide page the picture keeps its size, on a narrow one it shrinks.
  const auto width = std::to_string(std::max(1, figure.columns) * figure.panel_width);
  svg.insert(4, " style=\"max-width:" + width + "px\"");
  remove_empty_titles(svg, id);
  set_picture_title(svg, id, figure.title);
  return with_own_ids(svg, id);
}

void check_figure_path(const std::string& path) {
  format_of(path);
}

}  // namespace gyrator
