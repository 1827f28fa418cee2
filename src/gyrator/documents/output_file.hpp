#pragma once

#include <filesystem>
#include <fstream>
#include <ostream>
#include <string>
#include <string_view>

namespace gyrator {

/// Whether a file is on the disk, and not only in the system's memory, before it takes its name.
enum class Durability { as_the_system_likes, before_rename };

/// A file that appears whole or not at all: written beside its target, then renamed over it.
///
///     OutputFile file("trace.csv");
///     file.stream() << …;
///     file.commit();          // without it, the target stays as it was
///
/// The target keeps its permissions and, where it is a symbolic link, the link. A target that
/// exists and is no ordinary file (/dev/stdout, a pipe) is written directly, for there is
/// nothing to rename. Throws bad_input, with the file's name and the system's reason, where the
/// directory is missing or not writable, and in commit() where the disk is full.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  ~OutputFile();  ///< removes the temporary unless committed

  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  OutputFile(OutputFile&&) = delete;
  OutputFile& operator=(OutputFile&&) = delete;

  std::ostream& stream() { return stream_; }

  /// Where a library that writes files by their name has to write, instead of to the stream; to be
  /// closed before commit(). Empty where the target is written directly.
  const std::filesystem::path& temporary() const { return temporary_; }

  /// Flushes and renames; the stream must not be written afterwards. A second call does nothing.
  void commit(Durability durability = Durability::as_the_system_likes);

 private:
  std::string path_;                 // as the user wrote it, for messages
  std::filesystem::path target_;     // with symbolic links resolved
  std::filesystem::path temporary_;  // empty where the target is written directly
  std::ofstream stream_;
  bool committed_ = false;
};

/// Throws what OutputFile would, and leaves nothing: for before long work.
void check_writable(const std::string& path);

/// Writes `text` to `path`, whole or not at all. Errors as for OutputFile.
void write_text_file(const std::string& path, std::string_view text,
                     Durability durability = Durability::as_the_system_likes);

/// Makes what was renamed, made or removed in a folder lasting; where the system cannot, nothing
/// happens.
void sync_folder(const std::filesystem::path& folder);

}  // namespace gyrator
