#pragma once

#include <string>

namespace gyrator {

/// Runs gnuplot on `script`, given on its standard input, and returns the bytes of its standard
/// output. The user's own gnuplot settings are not read and no file is left behind.
/// Throws bad_input where gnuplot is not installed, interrupted where Ctrl-C ended it, and
/// numerical with gnuplot's own words where it refuses the script.
std::string run_gnuplot(const std::string& script);

}  // namespace gyrator
