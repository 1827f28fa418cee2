#include "gyrator/plots/gnuplot.hpp"

#include "gyrator/core/child_process.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/plots/pretty_text.hpp"

namespace gyrator {
namespace {

/// gnuplot's words on one line, without the columns of blanks around its caret.
std::string complaint(const std::string& errors) {
  std::string line;
  for (const char c : plain_text(errors))
    if (c != ' ' || (!line.empty() && line.back() != ' ')) line += c;
  return line;
}

}  // namespace

std::string run_gnuplot(const std::string& script) {
  const ChildResult drawn =
      run_child({.name = "gnuplot",
                 .arguments = {"--default-settings"},  // not the user's ~/.gnuplot
                 .input = script,
                 .folder = {},
                 .remedy = "and plots are drawn with it: apt-get install gnuplot-nox"});
  if (!drawn.succeeded)
    throw Error(ErrorCode::numerical, "gnuplot",
                "could not draw the figure: " + complaint(drawn.errors));
  return drawn.output;
}

}  // namespace gyrator
