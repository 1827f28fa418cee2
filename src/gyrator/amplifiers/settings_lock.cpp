#include "gyrator/amplifiers/settings_lock.hpp"

#include "gyrator/core/error.hpp"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <sstream>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

// The same for every user.
std::filesystem::path lock_folder() {
  const std::filesystem::path common = "/run/lock";
  std::error_code ignored;
  const auto status = std::filesystem::status(common, ignored);
  const bool is_everybodys =
      std::filesystem::is_directory(status) &&
      (status.permissions() & std::filesystem::perms::others_write) != std::filesystem::perms::none;
  return is_everybodys ? common : "/tmp";
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

std::vector<std::string> find_lines(const std::string& note, const std::string& key) {
  std::vector<std::string> found;
  std::istringstream text(note);
  for (std::string line; std::getline(text, line);)
    if (line.starts_with(key + " ")) found.push_back(line.substr(key.size() + 1));
  return found;
}

int open_file(const std::filesystem::path& path, int mode) {
  // A pipe that somebody has put there must not make us wait.
  constexpr int always = O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  constexpr mode_t everybody = 0666;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): POSIX declares open() so
  return ::open(path.c_str(), mode | always, everybody);
}

// A file that is there is opened without O_CREAT, which Linux refuses for another user's in a
// common folder; one that may only be read can be locked all the same.
int open_lock_file(const std::filesystem::path& path) {
  constexpr int most_tries = 100;
  for (int i = 0; i < most_tries; ++i) {
    int file = open_file(path, O_RDWR);
    if (file < 0 && errno == EACCES) file = open_file(path, O_RDONLY);
    if (file >= 0 || errno != ENOENT) return file;
    file = open_file(path, O_RDWR | O_CREAT | O_EXCL);
    if (file >= 0) {
      ::fchmod(file, 0666);  // whatever the umask is
      return file;
    }
    if (errno != EEXIST) return file;
  }
  return -1;
}

// Whether the path still leads to the file: the holder before may have removed it.
bool is_file_of(int file, const std::filesystem::path& path) {
  struct stat opened {
  }, named{};
  return ::fstat(file, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace

SettingsLock::SettingsLock(const std::string& what) : path_(lock_folder() / file_name(what)) {
  for (;;) {
    file_ = open_lock_file(path_);
    if (file_ < 0) {
      throw Error(ErrorCode::device, path_.string(),
                  "the lock file cannot be opened: " + std::generic_category().message(errno));
    }
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
      const std::vector<std::string> holder = find_lines(read_note(file_), "pid");
      ::close(file_);
      throw Error(
          ErrorCode::device, what,
          fmt::format("is in use by process {}: two tuners must not fight; wait for its end "
                      "(lock file {})",
                      holder.empty() ? "unknown" : holder.front(), path_.string()));
    }
    if (is_file_of(file_, path_)) break;
    ::close(file_);
  }
  journals_ = find_lines(read_note(file_), "journal");
  write_note();
}

SettingsLock::~SettingsLock() {
  if (journals_.empty()) ::unlink(path_.c_str());  // another user's stays, which costs nothing
  ::close(file_);
}

void SettingsLock::write_note() const {
  std::string note = fmt::format("pid {}\n", ::getpid());
  for (const std::string& journal : journals_) note += fmt::format("journal {}\n", journal);
  if (::ftruncate(file_, 0) != 0 || ::pwrite(file_, note.data(), note.size(), 0) < 0) return;
}

void SettingsLock::note_journals(std::vector<std::string> journals) {
  journals_ = std::move(journals);
  write_note();
}

}  // namespace gyrator
