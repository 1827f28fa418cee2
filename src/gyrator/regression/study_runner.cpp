#include "gyrator/regression/study_runner.hpp"

#include "gyrator/core/child_process.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/csv.hpp"
#include "gyrator/documents/input_file.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/regression/answer_path.hpp"
#include "gyrator/regression/figure_check.hpp"
#include "gyrator/regression/overridden_model.hpp"
#include "gyrator/studies/parallel.hpp"
#include "gyrator/studies/progress.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <thread>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// A folder that goes with its owner, whatever is in it.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::error_code failed;
    const fs::path parent = fs::temp_directory_path(failed);
    if (failed) {
      const char* given = std::getenv("TMPDIR");
      throw Error(ErrorCode::bad_input, "TMPDIR",
                  fmt::format("'{}': a folder for temporary files is expected: {}",
                              given == nullptr ? "" : given, failed.message()));
    }
    // Absolute: the runs work in the study's folder.
    std::string name = (fs::absolute(parent) / "gyrator-study-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw Error(ErrorCode::bad_input, name,
                  "cannot be made: " + std::generic_category().message(errno));
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ScratchFolder(ScratchFolder&&) = delete;
  ScratchFolder& operator=(ScratchFolder&&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// One start of the program.
struct Job {
  const RegressionRun* run = nullptr;
  fs::path folder;
  std::string model;  // of the command line
  fs::path csv;       // empty: not asked for
  PointAnswer* answer = nullptr;
};

fs::path folder_of(const RegressionStudy& study) {
  const fs::path folder = fs::path(study.file).parent_path();
  return folder.empty() ? "." : folder;
}

// As many as are asked for, and no more than the environment allows.
int count_threads(int asked) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int threads = asked > 0 ? asked : cores;
  const int limit = read_threads_variable();
  return limit > 0 ? std::min(threads, limit) : threads;
}

// "delay" of studies/delay/study.json.
std::string folder_name_of(const RegressionStudy& study) {
  return std::filesystem::absolute(study.file).parent_path().filename().string();
}

void refuse_filter(const std::vector<RegressionStudy>& studies, const std::string& filter) {
  constexpr std::size_t few = 8;
  std::vector<std::string> names;
  std::vector<std::string> runs;
  for (const RegressionStudy& study : studies) {
    for (const RegressionRun& run : study.runs) {
      names.push_back(folder_name_of(study) + "/" + run.name);
      runs.push_back(run.name);
    }
  }
  std::string hint = suggest_name(filter, runs);
  if (hint.empty()) hint = suggest_name(filter, names);
  const std::size_t left = names.size() - std::min(few, names.size());
  names.resize(names.size() - left);
  throw Error(ErrorCode::bad_input, "--filter",
              fmt::format("'{}': is in no run's name; there are {}{}{}", filter, join(names),
                          left > 0 ? fmt::format(" and {} more", left) : "", hint));
}

class Runner {
 public:
  Runner(const std::vector<RegressionStudy>& studies, const StudyRunOptions& options)
      : options_(options) {
    for (const RegressionStudy& study : studies) {
      StudyAnswers answers{&study, {}};
      for (const RegressionRun& run : study.runs)
        if (is_wanted(study, run, options.filter)) answers.runs.push_back(lay_out(study, run));
      answers_.push_back(std::move(answers));
    }
    if (std::all_of(answers_.begin(), answers_.end(),
                    [](const StudyAnswers& study) { return study.runs.empty(); }))
      refuse_filter(studies, options.filter);
    for (StudyAnswers& study : answers_)  // when no vector grows any more
      for (RunAnswer& run : study.runs) add_jobs(*study.study, run);
  }

  std::vector<StudyAnswers> run() {
    const int threads = count_threads(options_.threads);
    const int at_once = std::min<int>(threads, static_cast<int>(jobs_.size()));
    Progress progress("study", jobs_.size(), options_.quiet);
    run_parallel(jobs_.size(), at_once, [&](std::size_t i) {
      work(jobs_[i], std::max(1, threads / at_once));
      progress.advance();
    });
    return std::move(answers_);
  }

 private:
  static std::string place_of(const RegressionStudy& study, const RegressionRun& run) {
    for (std::size_t i = 0; i < study.runs.size(); ++i)
      if (&study.runs[i] == &run) return fmt::format("{}: /runs/{}", study.file, i);
    return study.file;
  }

  static RunAnswer lay_out(const RegressionStudy& study, const RegressionRun& run) {
    RunAnswer answer;
    answer.run = &run;
    try {
      const OverridableModel model((folder_of(study) / run.model).string());
      answer.model_sha256 = model.sha256();
      answer.files = model.hash_named_files();
    } catch (const Error& error) {
      throw Error(error.code(), place_of(study, run) + "/model", error.what());
    }
    answer.points.resize(run.points());
    return answer;
  }

  void add_jobs(const RegressionStudy& study, RunAnswer& answer) {
    const RegressionRun& run = *answer.run;
    const OverridableModel model((folder_of(study) / run.model).string());
    const std::string place = place_of(study, run);
    for (std::size_t k = 0; k < answer.points.size(); ++k) {
      const std::vector<ValueToSet> values = list_values(run, k, place);
      const std::string stem = fmt::format("{}-{}", jobs_.size(), run.name);
      Job job{&run, folder_of(study), run.model, {}, &answer.points[k]};
      if (!values.empty()) {
        const json document = model.with_values(values);
        for (const ValueToSet& value : values)
          answer.points[k].set[value.path] = model.value_of(document, value.path);
        const fs::path file = scratch_.path() / (stem + ".json");
        write_text_file(file.string(), document.dump(1) + "\n");
        job.model = file.string();
      }
      if (run.command == "simulate") job.csv = scratch_.path() / (stem + ".csv");
      jobs_.push_back(std::move(job));
    }
  }

  static std::vector<ValueToSet> list_values(const RegressionRun& run, std::size_t point,
                                             const std::string& place) {
    std::vector<ValueToSet> values;
    for (const auto& [path, value] : run.set.items())
      values.push_back({path, value, fmt::format("{}/set/{}", place, path)});
    for (const VariedValue& varied : run.vary)
      values.push_back(
          {varied.path, varied.values[point], fmt::format("{}/vary/{}", place, varied.path)});
    if (run.seed && run.command != "tolerance") {
      values.push_back({run.seed_path(), *run.seed, place + "/seed"});
    }
    return values;
  }

  void work(const Job& job, int threads) const {
    throw_if_interrupted("study");
    ChildProgram program;
    program.name =
        options_.program.empty() ? fs::read_symlink("/proc/self/exe").string() : options_.program;
    program.folder = job.folder;
    program.environment = {{threads_variable, std::to_string(threads)}};
    program.arguments = {job.run->command, job.model};
    for (const std::string& word : job.run->arguments) program.arguments.push_back(word);
    if (job.run->seed && job.run->command == "tolerance") {
      program.arguments.emplace_back("--seed");
      program.arguments.push_back(std::to_string(*job.run->seed));
    }
    program.arguments.emplace_back("--json");
    if (!job.csv.empty()) {
      program.arguments.emplace_back("--csv");
      program.arguments.push_back(job.csv.string());
    }
    const auto start = std::chrono::steady_clock::now();
    const ChildResult result = run_child(program);
    PointAnswer& answer = *job.answer;
    answer.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    answer.exit_code = result.exit_code;
    answer.errors = result.errors;
    // Refused or crashed: what came out, if anything, is no answer.
    answer.answer = json::parse(result.output, nullptr, false);
    if (answer.answer.is_discarded() || !answer.answer.is_object()) answer.answer = nullptr;
    if (answer.answer.is_object()) answer.answer["command_line"] = describe_command(job);
    if (options_.keep_csv && !job.csv.empty()) answer.csv = read_text_file_if_any(job.csv);
    if (job.run->trace && answer.answer.is_object()) read_trace(job);
  }

  static void read_trace(const Job& job) {
    try {
      job.answer->trace = read_trace_table(job.csv.string(), *job.run->trace);
    } catch (const Error& error) {  // where in the scratch folder helps nobody
      job.answer->trace_problem = error.message();
    }
  }

  // As a user would get the same, but for the values set.
  static std::string describe_command(const Job& job) {
    std::string text = fmt::format("gyrator {} {}", job.run->command, job.run->model);
    for (const std::string& word : job.run->arguments) text += " " + word;
    for (const auto& [path, value] : job.answer->set.items())
      text += fmt::format(", {} = {}", path, value.dump());
    return text;
  }

  const StudyRunOptions& options_;
  ScratchFolder scratch_;
  std::vector<StudyAnswers> answers_;
  std::vector<Job> jobs_;
};

}  // namespace

double RunAnswer::seconds() const {
  double sum = 0;
  for (const PointAnswer& point : points) sum += point.seconds;
  return sum;
}

std::string describe_exit(int code) {
  return code < 0 ? "ended by a signal" : fmt::format("exit code {}", code);
}

std::string first_error(const PointAnswer& point) {
  return std::string(trim(point.errors.substr(0, point.errors.find('\n'))));
}

bool is_wanted(const RegressionStudy& study, const RegressionRun& run, const std::string& filter) {
  return (study.name + "/" + run.name).find(filter) != std::string::npos ||
         (folder_name_of(study) + "/" + run.name).find(filter) != std::string::npos ||
         (study.file + "/" + run.name).find(filter) != std::string::npos;
}

std::vector<StudyAnswers> run_studies(const std::vector<RegressionStudy>& studies,
                                      const StudyRunOptions& options) {
  return Runner(studies, options).run();
}

json find_run_figure(const RunAnswer& run, const std::string& path) {
  json values = json::array();
  for (const PointAnswer& point : run.points) {
    if (path.starts_with("set.")) {
      const std::string key = path.substr(4);
      if (!point.set.contains(key)) {
        std::vector<std::string> known;
        for (const auto& item : point.set.items()) known.push_back("set." + item.key());
        throw Error(ErrorCode::bad_input, "", describe_unknown_name("value", path, known));
      }
      values.push_back(point.set[key]);
    } else if (point.answer.is_null()) {
      throw Error(ErrorCode::bad_input, "", "there is no answer");
    } else {
      values.push_back(find_in_answer(point.answer, path));
    }
  }
  return run.run->vary.empty() ? values.front() : values;
}

std::string describe_varied(const RunAnswer& run, std::size_t point) {
  std::vector<std::string> parts;
  for (const VariedValue& varied : run.run->vary) {
    const json& value = run.points[point].set[varied.path];
    const json kind = value.is_object() ? value.value("kind", json()) : json();
    parts.push_back(fmt::format("{} = {}", varied.path,
                                value.is_structured() && kind.is_null()
                                    ? fmt::format("#{}", point)
                                    : describe_figure(kind.is_null() ? value : kind, "")));
  }
  return join(parts);
}

TraceTable read_trace_table(const std::string& path, const TraceExpectation& tube) {
  std::vector<std::string> names{"time_s"};
  for (const TubeColumn& column : tube.columns) names.push_back(column.name);
  CsvColumns read = read_csv(path, names);
  TraceTable table;
  table.time_s = std::move(read.columns.front());
  read.columns.erase(read.columns.begin());
  table.columns = std::move(read.columns);
  return table;
}

}  // namespace gyrator
