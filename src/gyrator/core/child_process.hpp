#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace gyrator {

/// A program to run once, such as gnuplot or ngspice.
struct ChildProgram {
  std::string name;                    ///< searched in PATH
  std::vector<std::string> arguments;  ///< without the name
  std::string input;                   ///< what it reads on its standard input
  std::filesystem::path folder;        ///< where it works; empty for the current folder
  /// Variables of its environment, beside those of this program.
  std::vector<std::pair<std::string, std::string>> environment = {};
  std::string remedy;  ///< ends "is not installed, …": what it is for and how to install it
};

struct ChildResult {
  bool succeeded = false;  ///< ended by itself with exit code 0
  int exit_code = -1;      ///< -1: a signal ended it
  std::string output, errors;
};

/// Runs the program to its end. Its streams are files without names rather than pipes, so that
/// neither side waits for the other and nothing is left behind. Ctrl-C ends it too. May be called
/// from several threads at once.
/// Throws bad_input where it is not installed or cannot be started, interrupted after Ctrl-C.
ChildResult run_child(const ChildProgram& program);

}  // namespace gyrator
