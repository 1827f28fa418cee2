#include "gyrator/core/child_process.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <spawn.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>

namespace gyrator {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const {
    std::fclose(file);  // NOLINT(cppcoreguidelines-owning-memory): this is the owner
  }
};
/// A file without name: gone with its last handle, even if the program is killed.
using NamelessFile = std::unique_ptr<std::FILE, CloseFile>;

[[noreturn]] void fail(const ChildProgram& program, int reason) {
  throw Error(ErrorCode::bad_input, program.name,
              "cannot be run: " + std::generic_category().message(reason));
}

NamelessFile nameless_file(const ChildProgram& program) {
  NamelessFile file(std::tmpfile());
  if (!file) fail(program, errno);
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

std::vector<std::string> make_environment(const ChildProgram& program) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string text = *variable;
    const bool is_replaced =
        std::any_of(program.environment.begin(), program.environment.end(),
                    [&](const auto& given) { return text.starts_with(given.first + "="); });
    if (!is_replaced) variables.push_back(text);
  }
  for (const auto& [name, value] : program.environment) variables.push_back(name + "=" + value);
  return variables;
}

std::vector<char*> list_pointers(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (auto& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

pid_t start(const ChildProgram& program, std::FILE* input, std::FILE* output, std::FILE* errors) {
  posix_spawn_file_actions_t actions{};
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ::fileno(input), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ::fileno(output), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ::fileno(errors), STDERR_FILENO);
  if (!program.folder.empty())
    posix_spawn_file_actions_addchdir_np(&actions, program.folder.c_str());
  std::vector<std::string> words{program.name};
  words.insert(words.end(), program.arguments.begin(), program.arguments.end());
  std::vector<std::string> variables = make_environment(program);
  // What this process does with a broken pipe is its own matter.
  posix_spawnattr_t attributes{};
  posix_spawnattr_init(&attributes);
  sigset_t defaults{};
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  pid_t child = 0;
  const int refused = ::posix_spawnp(&child, program.name.c_str(), &actions, &attributes,
                                     list_pointers(words).data(), list_pointers(variables).data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (refused == ENOENT)
    throw Error(ErrorCode::bad_input, program.name, "is not installed, " + program.remedy);
  if (refused != 0) fail(program, refused);
  return child;
}

/// waitpid's status at the child's end. A signal wakes only one of the threads that wait: each
/// looks by itself whether one has come.
int wait_for(const ChildProgram& program, pid_t child) {
  using std::chrono::milliseconds;
  using Clock = std::chrono::steady_clock;
  constexpr milliseconds longest_pause{20};
  // What it takes a program to put away what it has open; one that writes on is ended.
  constexpr milliseconds patience{500};
  milliseconds pause{1};
  std::optional<Clock::time_point> told;
  int status = 0;
  while (true) {
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child) return status;
    if (ended < 0 && errno != EINTR) fail(program, errno);
    if (interrupt_requested() && !told) {
      ::kill(child, SIGTERM);
      told = Clock::now();
    }
    if (told && Clock::now() - *told > patience) ::kill(child, SIGKILL);
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, longest_pause);
  }
}

}  // namespace

ChildResult run_child(const ChildProgram& program) {
  const auto input = nameless_file(program);
  const auto output = nameless_file(program);
  const auto errors = nameless_file(program);
  const std::string& text = program.input;
  if (std::fwrite(text.data(), 1, text.size(), input.get()) != text.size() ||
      std::fflush(input.get()) != 0)
    fail(program, errno);
  std::rewind(input.get());

  const int status = wait_for(program, start(program, input.get(), output.get(), errors.get()));
  throw_if_interrupted(program.name);
  const int exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return {exit_code == 0, exit_code, content_of(output.get()), content_of(errors.get())};
}

}  // namespace gyrator
