#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace gyrator::app {

/// What is asked of regression studies.
struct RegressionRequest {
  std::vector<std::string> files;
  std::string filter;
  int threads = 0;
  bool as_json = false, quiet = false;
};

/// Whether a file, or the study.json of a folder, is a regression study; what cannot be read is
/// none.
bool is_regression_file(const std::string& path);

/// `study run` of a regression study: all answers and figures into a folder.
void run_regression_study(const RegressionRequest& request, const std::string& folder,
                          int& exit_code);

void add_check_command(CLI::App& study, int& exit_code);
void add_update_command(CLI::App& study, int& exit_code);

}  // namespace gyrator::app
