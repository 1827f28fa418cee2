#pragma once

#include <string>
#include <vector>

namespace gyrator {

/// The numbers of a file that ngspice's `wrdata` has written with `wr_singlescale` and
/// `wr_vecnames`: a first line of names, then columns. Complex vectors take two columns each.
struct NgspiceTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
};

/// Reads such a file's text. Throws numerical where a row is not of as many numbers as the first.
NgspiceTable parse_ngspice_table(const std::string& text);

/// Runs `ngspice -b` on the deck in a temporary folder, without the user's .spiceinit, and returns
/// the tables that it wrote there, by the names asked for.
/// Throws bad_input where ngspice is not installed, interrupted after Ctrl-C, and numerical with
/// ngspice's own words where it refuses the deck or leaves no such file.
std::vector<NgspiceTable> run_ngspice(const std::string& deck,
                                      const std::vector<std::string>& files);

}  // namespace gyrator
