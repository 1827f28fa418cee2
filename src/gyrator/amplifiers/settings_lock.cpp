#include "gyrator/amplifiers/settings_lock.hpp"

#include "gyrator/core/error.hpp"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>

#include <fmt/core.h>

namespace gyrator {
namespace {

std::filesystem::path lock_folder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  std::error_code ignored;
  if (runtime != nullptr && std::filesystem::is_directory(runtime, ignored)) return runtime;
  return "/tmp";
}

std::string file_name(const std::string& device) {
  std::string name = "gyrator-";
  for (const char c : device) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                       c == '.' || c == '-';
    name += plain ? c : '_';
  }
  return name + ".lock";
}

// "pid 4711\njournal /path\n"
std::string read_note(int file) {
  std::array<char, 8192> bytes{};
  const ssize_t size = ::pread(file, bytes.data(), bytes.size(), 0);
  return size > 0 ? std::string(bytes.data(), static_cast<std::size_t>(size)) : std::string();
}

std::string find_line(const std::string& note, const std::string& key) {
  const std::size_t at = note.find(key + " ");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + key.size() + 1;
  return note.substr(begin, note.find('\n', begin) - begin);
}

}  // namespace

SettingsLock::SettingsLock(const std::string& device) : path_(lock_folder() / file_name(device)) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): POSIX declares open() so
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file_ < 0) {
    throw Error(ErrorCode::device, path_.string(),
                "the lock file cannot be opened: " + std::generic_category().message(errno));
  }
  const bool is_locked = ::flock(file_, LOCK_EX | LOCK_NB) == 0;
  const std::string note = read_note(file_);
  if (!is_locked) {
    ::close(file_);
    const std::string holder = find_line(note, "pid");
    throw Error(ErrorCode::device, device,
                fmt::format("is in use by process {}: two tuners must not fight; wait for its end "
                            "(lock file {})",
                            holder.empty() ? "unknown" : holder, path_.string()));
  }
  const std::string journal = find_line(note, "journal");
  if (!journal.empty()) unfinished_ = journal;
  write_note(journal);
}

SettingsLock::~SettingsLock() {
  ::close(file_);
}

void SettingsLock::write_note(const std::string& journal) const {
  std::string note = fmt::format("pid {}\n", ::getpid());
  if (!journal.empty()) note += fmt::format("journal {}\n", journal);
  // A note that cannot be written costs only the hint after a crash.
  if (::ftruncate(file_, 0) != 0 || ::pwrite(file_, note.data(), note.size(), 0) < 0) return;
}

void SettingsLock::note_journal(const std::string& journal) {
  write_note(journal);
}

void SettingsLock::finish() {
  write_note({});
}

}  // namespace gyrator
