#include "gyrator/plots/interactive_figure.hpp"

#include "gyrator/plots/figure_json.hpp"
#include "gyrator/plots/html.hpp"

namespace gyrator {

std::string html_interactive_figure(const Figure& figure, const std::string& id,
                                    const std::string& caption) {
  return "<figure class=\"interactive\">\n<div class=\"scroll picture\">" +
         figure_as_svg(figure, id) +
         "</div>\n<script type=\"application/json\" class=\"figure-data\">" +
         figure_as_json(figure) + "</script>\n<figcaption>" + html_escape(caption) +
         "</figcaption>\n</figure>\n";
}

}  // namespace gyrator
