#include "gyrator/core/child_process.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"

#include <array>
#include <cerrno>
#include <csignal>
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
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
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
                                     arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (refused == ENOENT)
    throw Error(ErrorCode::bad_input, program.name, "is not installed, " + program.remedy);
  if (refused != 0) fail(program, refused);
  return child;
}

/// waitpid's status at the child's end.
int wait_for(const ChildProgram& program, pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) fail(program, errno);
    if (interrupt_requested()) ::kill(child, SIGTERM);
  }
  return status;
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
  return {WIFEXITED(status) && WEXITSTATUS(status) == 0, content_of(output.get()),
          content_of(errors.get())};
}

}  // namespace gyrator
