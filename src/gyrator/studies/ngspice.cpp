#include "gyrator/studies/ngspice.hpp"

#include "gyrator/core/child_process.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>

#include <fmt/core.h>

namespace gyrator {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& message) {
  throw Error(ErrorCode::numerical, "ngspice", message);
}

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "gyrator-ngspice-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw Error(ErrorCode::bad_input, name,
                  "cannot be made: " + std::generic_category().message(errno));
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  TemporaryFolder(TemporaryFolder&&) = delete;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// The lines in which ngspice says what is wrong, on one line.
std::string complaint(const ChildResult& run) {
  std::istringstream lines(run.errors + "\n" + run.output);
  std::vector<std::string> found;
  for (std::string line; std::getline(lines, line) && found.size() < 4;) {
    const bool tells =
        line.find("rror") != std::string::npos || line.find("arning") != std::string::npos ||
        line.find("singular") != std::string::npos || line.find("too small") != std::string::npos;
    if (tells) found.emplace_back(trim(line));
  }
  return found.empty() ? "it says nothing" : join(found, "; ");
}

}  // namespace

NgspiceTable parse_ngspice_table(const std::string& text) {
  NgspiceTable table;
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  std::istringstream header(line);
  table.names.assign(std::istream_iterator<std::string>(header), {});
  table.columns.resize(table.names.size());
  while (std::getline(lines, line)) {
    const char* at = line.c_str();
    std::size_t count = 0;
    for (char* end = nullptr;; at = end, ++count) {
      const double value = std::strtod(at, &end);
      if (end == at) break;
      if (count < table.columns.size()) table.columns[count].push_back(value);
    }
    if (count == 0) continue;  // a blank line ends a sweep
    if (count != table.columns.size()) {
      fail(fmt::format("a row of {} numbers under {} names: {}", count, table.names.size(), line));
    }
  }
  return table;
}

std::vector<NgspiceTable> run_ngspice(const std::string& deck,
                                      const std::vector<std::string>& files) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "deck.cir", std::ios::binary) << deck;
  const ChildResult run =
      run_child({.name = "ngspice",
                 .arguments = {"-n", "-b", "deck.cir"},
                 .input = {},
                 .folder = folder.path(),
                 .remedy = "and netlists are checked with it: apt-get install ngspice"});
  std::vector<NgspiceTable> tables;
  for (const auto& name : files) {
    std::ifstream file(folder.path() / name, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    // A transient that it gives up leaves what there is, and exit code 0.
    const bool aborted = run.output.find("aborted") != std::string::npos ||
                         run.errors.find("aborted") != std::string::npos;
    if (!run.succeeded || aborted || text.empty())
      fail("did not finish the netlist: " + complaint(run));
    tables.push_back(parse_ngspice_table(text));
  }
  return tables;
}

}  // namespace gyrator
