#pragma once

#include "gyrator/sweeps/sweep_store.hpp"

#include <cstdint>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace gyrator {

/// "sweep.h5.journal" of "sweep.h5".
std::string journal_name(const std::string& result);

/// The results of a sweep that is under way, on the disk after every chunk.
///
///   file   = record { record }                the first is the header, the rest chunks
///   record = "gsj1" length(4) crc32(4) payload      numbers with the least byte first
///
/// The header is JSON: the study, the model's text and a digest over all that decides a number.
/// What a crash or a full disk has left of a last record is recognised and dropped.
/// One process at a time may have it open.
class SweepJournal {
 public:
  /// Opens the journal of this study, or begins it; what it holds goes into the store. Throws
  /// bad_input where the file is of another study, no journal, in use, or cannot be written.
  /// `restart` throws away the journal that is there, of whatever study.
  SweepJournal(std::string path, const SweepPlan& plan, SweepStore& store, bool restart);
  ~SweepJournal();

  SweepJournal(const SweepJournal&) = delete;
  SweepJournal& operator=(const SweepJournal&) = delete;
  SweepJournal(SweepJournal&&) = delete;
  SweepJournal& operator=(SweepJournal&&) = delete;

  /// On the disk when it returns. Throws bad_input where that cannot be.
  void append(const ChunkResult& result);
  /// Once the result is written.
  void remove();

  const std::string& path() const { return path_; }

 private:
  void begin(const SweepPlan& plan);
  // Whether the path still names what was opened, once it is locked.
  bool open_locked();
  void resume(const SweepPlan& plan, SweepStore& store, bool restart);
  void write_record(std::string_view payload);
  [[noreturn]] void fail(int reason) const;

  std::string path_;
  int file_ = -1;
};

/// A journal as it stands, perhaps while it is written.
struct JournalContent {
  SweepPlan plan;
  SweepStore store;
};
bool is_journal(const std::string& path);
/// Throws bad_input for a file that is none, or has not even its header.
JournalContent read_journal(const std::string& path);

}  // namespace gyrator
