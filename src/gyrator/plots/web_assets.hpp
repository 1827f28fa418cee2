#pragma once

#include <string>

namespace gyrator {

/// The script and the style of the interactive figures, web/figures.js and web/figures.css: made
/// by web/build at the top of the source tree, put into the program when it is built.
std::string figure_script();
std::string figure_style();

}  // namespace gyrator
