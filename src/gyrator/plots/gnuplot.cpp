#include "gyrator/plots/gnuplot.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/plots/pretty_text.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <spawn.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

namespace gyrator {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const {
    std::fclose(file);  // NOLINT(cppcoreguidelines-owning-memory): this is the owner
  }
};
/// A file without name: gone with its last handle, even if the program is killed. Files rather
/// than pipes, because then neither side ever waits for the other.
using NamelessFile = std::unique_ptr<std::FILE, CloseFile>;

[[noreturn]] void fail(int reason) {
  throw Error(ErrorCode::bad_input, "gnuplot",
              "cannot be run: " + std::generic_category().message(reason));
}

NamelessFile nameless_file() {
  NamelessFile file(std::tmpfile());
  if (!file) fail(errno);
  return file;
}

std::string content_of(std::FILE* file) {
  std::string content;
  std::array<char, 1 << 14> buffer{};
  std::rewind(file);
  for (std::size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), file)) > 0;)
    content.append(buffer.data(), n);
  return content;
}

/// Starts gnuplot on the three files and waits for its end; returns waitpid's status.
int run(std::FILE* input, std::FILE* output, std::FILE* errors) {
  posix_spawn_file_actions_t actions{};
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ::fileno(input), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ::fileno(output), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ::fileno(errors), STDERR_FILENO);
  std::string name = "gnuplot";
  std::string defaults = "--default-settings";  // not the user's ~/.gnuplot
  const std::array<char*, 3> arguments = {name.data(), defaults.data(), nullptr};
  pid_t child = 0;
  const int refused =
      ::posix_spawnp(&child, name.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (refused == ENOENT)
    throw Error(ErrorCode::bad_input, "gnuplot",
                "is not installed, and plots are drawn with it: apt-get install gnuplot-nox");
  if (refused != 0) fail(refused);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) fail(errno);
  return status;
}

/// gnuplot's words on one line, without the columns of blanks around its caret.
std::string complaint(std::FILE* errors) {
  std::string line;
  for (const char c : plain_text(content_of(errors)))
    if (c != ' ' || (!line.empty() && line.back() != ' ')) line += c;
  return line;
}

}  // namespace

std::string run_gnuplot(const std::string& script) {
  const auto input = nameless_file();
  const auto output = nameless_file();
  const auto errors = nameless_file();
  if (std::fwrite(script.data(), 1, script.size(), input.get()) != script.size() ||
      std::fflush(input.get()) != 0)
    fail(errno);
  std::rewind(input.get());

  const int status = run(input.get(), output.get(), errors.get());
  throw_if_interrupted("gnuplot");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw Error(ErrorCode::numerical, "gnuplot",
                "could not draw the figure: " + complaint(errors.get()));
  return content_of(output.get());
}

}  // namespace gyrator
