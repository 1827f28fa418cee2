#include "regression_commands.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/regression/check_report.hpp"
#include "gyrator/regression/study_pictures.hpp"
#include "gyrator/regression/study_update.hpp"
#include "gyrator/version.hpp"

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <unistd.h>
#include <vector>

#include <fmt/core.h>

#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

struct CheckOptions {
  RegressionRequest request;
  long threads = 0;
  std::string junit;
  bool yes = false, verbose = false;
};

std::string study_of(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) ? (fs::path(path) / "study.json").string() : path;
}

void print_json(const json& value) {
  fmt::print("{}\n", value.dump(-1, ' ', false, json::error_handler_t::replace));
}

std::vector<RegressionStudy> load_studies(const std::vector<std::string>& files) {
  std::vector<RegressionStudy> studies;
  std::vector<std::string> seen;
  for (const std::string& file : files) {
    studies.push_back(load_regression_study(study_of(file)));
    std::error_code ignored;
    seen.push_back(fs::weakly_canonical(studies.back().file, ignored).string());
  }
  if (const auto twice = find_repeated(seen))
    throw Error(ErrorCode::bad_input, *twice, "is given twice: once is enough");
  return studies;
}

StudyRunOptions make_options(const RegressionRequest& request) {
  StudyRunOptions options;
  options.filter = request.filter;
  options.threads = request.threads;
  options.quiet = request.quiet;
  return options;
}

// GitHub wants files as seen from the repository.
std::vector<CheckRow> seen_from_repository(std::vector<CheckRow> rows) {
  const char* root = std::getenv("GITHUB_WORKSPACE");
  if (root == nullptr || *root == '\0') return rows;
  for (CheckRow& row : rows) {
    std::error_code failed;
    const fs::path path = fs::relative(row.study_file, root, failed);
    if (!failed && !path.empty() && path.begin()->string() != "..") row.study_file = path.string();
  }
  return rows;
}

void annotate(const std::vector<CheckRow>& rows, bool on_stderr) {
  const char* actions = std::getenv("GITHUB_ACTIONS");
  if (actions == nullptr || std::string(actions) != "true") return;
  const std::string text = write_github_annotations(seen_from_repository(rows));
  fmt::print(on_stderr ? stderr : stdout, "{}", text);
}

std::vector<CheckRow> check_all(const std::vector<StudyAnswers>& answers, bool whole) {
  std::vector<CheckRow> rows;
  for (const StudyAnswers& study : answers)
    for (CheckRow& row : check_study(study, whole)) rows.push_back(std::move(row));
  return rows;
}

void check(const CheckOptions& options, int& exit_code) {
  const RegressionRequest& request = options.request;
  const auto studies = load_studies(request.files);
  std::vector<NamedFile> inputs;
  inputs.reserve(studies.size());
  for (const RegressionStudy& study : studies) inputs.push_back({"the study", study.file});
  check_files(inputs, {{"--junit", options.junit}});
  const auto answers = run_studies(studies, make_options(request));
  const std::vector<CheckRow> rows = check_all(answers, request.filter.empty());
  if (!options.junit.empty()) write_text_file(options.junit, write_junit(rows));
  if (request.as_json) {
    print_json(make_check_result(rows));
  } else if (!request.quiet) {
    fmt::print("{}", describe_check(rows, options.verbose));
  }
  annotate(rows, request.as_json);
  exit_code = count_rows(rows).failed == 0 ? 0 : 1;
}

bool confirm(const std::string& file) {
  fmt::print("write {}? [y/N] ", file);
  std::fflush(stdout);
  std::string answer;
  std::getline(std::cin, answer);
  throw_if_interrupted("study update");
  return answer == "y" || answer == "Y" || answer == "yes";
}

void update(const CheckOptions& options, int& exit_code) {
  const RegressionRequest& request = options.request;
  const auto studies = load_studies(request.files);
  if (!options.yes && ::isatty(STDIN_FILENO) == 0) {
    throw Error(ErrorCode::bad_input, "study update",
                "asks before it writes, but stdin is no terminal: --yes writes without asking");
  }
  const auto answers = run_studies(studies, make_options(request));
  for (const StudyAnswers& study : answers) {
    if (study.runs.empty()) continue;  // filtered out
    const StudyUpdate planned = plan_update(study, request.filter.empty());
    const std::string file = baseline_name(planned.study_file);
    if (planned.is_empty()) {
      if (!request.quiet) fmt::print("{}: nothing has changed\n", file);
      continue;
    }
    if (!request.quiet || !options.yes)
      for (const std::string& line : planned.changes) fmt::print("{}\n", line);
    if (!options.yes && !confirm(file)) {
      fmt::print("{}: left as it was\n", file);
      exit_code = 1;
      continue;
    }
    write_update(planned);
    if (!request.quiet) fmt::print("{}\n", file);
  }
}

void add_request(CLI::App& command, CheckOptions& options) {
  command.add_option("STUDIES", options.request.files, "Study files (JSON), or their folders")
      ->required()
      ->check(not_empty());
  command.add_option("--filter", options.request.filter, "Only runs with this text in STUDY/RUN")
      ->type_name("TEXT")
      ->check(not_empty());
  command.add_option("--threads", options.threads, "Cores to use; by default all")
      ->type_name("N")
      ->check(whole_number_between(1, 1024));
  command.add_flag("--quiet", options.request.quiet, "No text and no progress");
}

}  // namespace

bool is_regression_file(const std::string& path) {
  try {
    return is_regression_study(load_json_file(study_of(path)));
  } catch (const Error&) {  // told once, by whoever reads it, in whatever number of processes
    return false;
  }
}

void run_regression_study(const RegressionRequest& request, const std::string& folder,
                          int& exit_code) {
  std::error_code ignored;
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored)) {
    throw Error(
        ErrorCode::bad_input, "--output",
        fmt::format("'{}': is a file: the results of a regression study are a folder's", folder));
  }
  const auto studies = load_studies(request.files);
  check_results_folder(studies.front(), folder, request.filter);
  StudyRunOptions options = make_options(request);
  options.keep_csv = true;
  const auto answers = run_studies(studies, options);
  const std::vector<CheckRow> rows = check_all(answers, request.filter.empty());
  const auto written = write_study_results(answers.front(), rows, folder);
  const CheckCounts counts = count_rows(rows);
  if (request.as_json) {
    print_json({{"command", "study run"},
                {"program", fmt::format("gyrator {}", version)},
                {"output", folder},
                {"files", written},
                {"figures", counts.rows},
                {"failed", counts.failed}});
  } else if (!request.quiet) {
    fmt::print("{}: {} in {}; {} of {} as expected (`gyrator study check` tells more)\n",
               studies.front().name, describe_count(written.size(), "file"), folder,
               counts.rows - counts.failed, describe_count(counts.rows, "figure"));
  }
  for (const std::string& reason : list_undrawn_figures(answers.front()))
    fmt::print(stderr, "gyrator: {}\n", reason);
  for (const CheckRow& row : rows) {
    if (row.figure != "exit code" || row.outcome != RowOutcome::failed) continue;
    fmt::print(stderr, "gyrator: {}\n", row.explanation);
    exit_code = static_cast<int>(ErrorCode::numerical);
  }
}

void add_check_command(CLI::App& study, int& exit_code) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = study.add_subcommand(
      "check", "Run regression studies and compare their figures with what they must be");
  add_request(*command, *options);
  command->add_option("--junit", options->junit, "Also write the result as JUnit XML")
      ->type_name("FILE")
      ->check(not_empty());
  command->add_flag("--verbose", options->verbose, "Print every figure, not only what failed");
  command->add_flag("--json", options->request.as_json, "Print one JSON object and nothing else");
  command->footer(
      "Example:\n  gyrator study check studies/first_wall/study.json --junit studies.xml\n\n"
      "In GitHub Actions each regression is annotated too. Exit codes: 0 all as expected, 1 a "
      "regression, 2 bad input.");
  command->callback([options, &exit_code] {
    options->request.threads = static_cast<int>(options->threads);
    check(*options, exit_code);
  });
}

void add_update_command(CLI::App& study, int& exit_code) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = study.add_subcommand(
      "update", "Run regression studies and write their figures as the new baseline");
  add_request(*command, *options);
  command->add_flag("--yes", options->yes, "Write without asking");
  command->footer(
      "Example:\n  gyrator study update studies/first_wall/study.json --yes\n\n"
      "Exit codes: 0 done, 1 left as it was, 2 bad input.");
  command->callback([options, &exit_code] {
    options->request.threads = static_cast<int>(options->threads);
    update(*options, exit_code);
  });
}

}  // namespace gyrator::app
