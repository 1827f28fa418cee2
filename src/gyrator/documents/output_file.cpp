#include "gyrator/documents/output_file.hpp"

#include "gyrator/core/error.hpp"

#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

namespace gyrator {
namespace {

[[noreturn]] void fail(const std::string& path, int reason) {
  throw Error(ErrorCode::bad_input, path,
              "cannot be written: " + std::generic_category().message(reason));
}

/// A name beside `target` that no other file, thread or process has.
std::filesystem::path name_beside(const std::filesystem::path& target) {
  static std::atomic<unsigned> count{0};
  const auto name = fmt::format(".{}.{}-{}.part", target.filename().string(), ::getpid(), ++count);
  return target.parent_path() / name;
}

void sync_file(const std::filesystem::path& file, const std::string& name) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): POSIX declares open() so
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail(name, errno);
  const int reason = ::fsync(descriptor) == 0 ? 0 : errno;
  ::close(descriptor);
  if (reason != 0) fail(name, reason);
}

}  // namespace

OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (path.empty()) throw Error(ErrorCode::bad_input, "output file", "the name is empty");
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  if (std::filesystem::is_directory(status)) fail(path, EISDIR);

  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    stream_.open(path, std::ios::binary);
    if (!stream_) fail(path, errno);
    return;
  }
  target_ = std::filesystem::weakly_canonical(path, ignored);  // a link stays a link
  if (target_.empty()) target_ = path;
  if (std::filesystem::exists(status) && ::access(target_.c_str(), W_OK) != 0) fail(path, errno);

  const auto beside = name_beside(target_);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): POSIX declares open() so
  const int descriptor = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) fail(path, errno);
  temporary_ = beside;
  if (std::filesystem::exists(status))
    ::fchmod(descriptor, static_cast<mode_t>(status.permissions()));
  ::close(descriptor);
  stream_.open(temporary_, std::ios::binary);
  if (!stream_) {
    const int reason = errno;
    std::filesystem::remove(temporary_, ignored);
    fail(path, reason);
  }
}

OutputFile::~OutputFile() {
  if (committed_ || temporary_.empty()) return;
  stream_.close();
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void OutputFile::commit(Durability durability) {
  if (committed_) return;
  errno = 0;
  stream_.close();  // flushes; a full disk shows here or in an earlier write
  if (!stream_) fail(path_, errno != 0 ? errno : EIO);
  const bool lasting = durability == Durability::before_rename && !temporary_.empty();
  if (lasting) sync_file(temporary_, path_);
  if (!temporary_.empty() && ::rename(temporary_.c_str(), target_.c_str()) != 0) fail(path_, errno);
  committed_ = true;
  if (lasting) sync_folder(target_.parent_path());
}

void check_writable(const std::string& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  const bool is_direct = std::filesystem::exists(status) &&
                         !std::filesystem::is_directory(status) &&
                         !std::filesystem::is_regular_file(status);
  if (!is_direct) {
    const OutputFile probe(path);
  } else if (::access(path.c_str(), W_OK) != 0) {  // opening a pipe would already be heard
    fail(path, errno);
  }
}

void write_text_file(const std::string& path, std::string_view text, Durability durability) {
  OutputFile file(path);
  file.stream().write(text.data(), static_cast<std::streamsize>(text.size()));
  file.commit(durability);
}

void sync_folder(const std::filesystem::path& folder) {
  const std::filesystem::path named = folder.empty() ? "." : folder;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): POSIX declares open() so
  const int descriptor = ::open(named.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace gyrator
