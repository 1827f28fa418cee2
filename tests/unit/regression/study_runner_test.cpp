#include "gyrator/regression/study_runner.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/regression/study_pictures.hpp"
#include "gyrator/studies/parallel.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// A program that answers how many threads it may use, and says so wherever it is.
class StudyRunner : public ::testing::Test {
 protected:
  StudyRunner() {
    std::string name = (fs::temp_directory_path() / "gyrator-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    study_ = parse_regression_study(
        json::parse(R"({"schema": "gyrator/regression/1", "name": "A study", "runs": [
          {"name": "one", "command": "passivity", "model": "m.json"}]})"),
        (folder_ / "study.json").string());
    write("m.json", "{}");
  }
  ~StudyRunner() override {
    ::unsetenv(threads_variable);
    fs::remove_all(folder_);
  }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  json run(int threads) const {
    const fs::path program =
        write("program", "#!/bin/sh\necho \"{\\\"threads\\\": $GYRATOR_THREADS}\"\n");
    fs::permissions(program, fs::perms::owner_all);
    StudyRunOptions options;
    options.program = program.string();
    options.threads = threads;
    return run_studies({study_}, options).at(0).runs.at(0).points.at(0).answer;
  }

  fs::path folder_;
  RegressionStudy study_;
};

TEST_F(StudyRunner, TheEnvironmentIsAnUpperLimitOfTheThreads) {
  ::setenv(threads_variable, "3", 1);
  EXPECT_EQ(run(8).at("threads"), 3);
  EXPECT_EQ(run(2).at("threads"), 2);
  ::unsetenv(threads_variable);
  EXPECT_EQ(run(8).at("threads"), 8);
}

TEST_F(StudyRunner, AFolderAsAFileOfTheModelIsRefused) {
  fs::create_directory(folder_ / "netlist.cir");
  write("m.json", R"({"damping": [{"file": "netlist.cir"}]})");
  try {
    run(1);
    ADD_FAILURE() << "a folder was read";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_NE(error.message().find("netlist.cir: is a folder"), std::string::npos) << error.what();
  }
}

TEST_F(StudyRunner, ResultsNeverTakeTheNameOfWhatTheStudyReads) {
  const std::string own = folder_.string();
  check_results_folder(study_, own, "");
  write("one.json", R"({"model": "m.json"})");  // of an earlier run
  check_results_folder(study_, own, "");
  study_.runs[0].model = "one.json";
  EXPECT_THROW(check_results_folder(study_, own, ""), Error);
  check_results_folder(study_, (folder_ / "out").string(), "");
  study_.runs[0].model = "m.json";
  write("m.json", R"({"model": "one.json"})");  // as a design's spec names its model
  EXPECT_THROW(check_results_folder(study_, own, ""), Error);
  write("m.json", "{}");
  study_.runs[0].name = "study";
  EXPECT_NO_THROW(check_results_folder(study_, own, ""));  // there is none yet
  write("study.json", "{}");
  EXPECT_THROW(check_results_folder(study_, own, ""), Error);
  EXPECT_NO_THROW(check_results_folder(study_, own, "another"));
}

}  // namespace
}  // namespace gyrator
