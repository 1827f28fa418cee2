#include "gyrator/amplifiers/settings_journal.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/documents/output_file.hpp"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <fcntl.h>
#include <sstream>
#include <system_error>
#include <unistd.h>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

[[noreturn]] void fail(const std::filesystem::path& path, int reason) {
  throw Error(ErrorCode::device, path.string(),
              fmt::format("the journal cannot be written: {}: without one nothing is written to "
                          "the device",
                          std::generic_category().message(reason)));
}

std::filesystem::path state_folder() {
  if (const char* state = std::getenv("XDG_STATE_HOME"); state != nullptr && *state != '\0')
    return std::filesystem::path(state) / "gyrator";
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0')
    return std::filesystem::path(home) / ".local/state/gyrator";
  return std::filesystem::path("/tmp") / fmt::format("gyrator-{}", ::getuid());
}

// The lines that are whole; the first decides whether it is a journal at all.
std::vector<json> read_lines(const std::string& path) {
  std::istringstream text(load_json_text(path));
  std::vector<json> lines;
  for (std::string line; std::getline(text, line);) {
    json record = json::parse(line, nullptr, false);
    if (record.is_discarded() || !record.is_object()) continue;
    lines.push_back(std::move(record));
  }
  const bool is_journal =
      !lines.empty() && lines.front().value("schema", "") == journal_schema_name;
  if (!is_journal) {
    throw Error(ErrorCode::bad_input, path,
                "is no journal of an amplifier's settings, which begins with \"schema\": "
                "\"gyrator/amplifier-journal/1\"");
  }
  return lines;
}

}  // namespace

std::string_view name_of(DeviceState state) {
  constexpr std::array<std::string_view, 3> names{"safe", "changed", "unknown"};
  return names.at(static_cast<std::size_t>(state));
}

SettingsJournal::SettingsJournal(const std::filesystem::path& path, const json& header)
    : path_(path) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): POSIX declares open() so
  file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) fail(path_, errno);
  try {
    append(header, true);
    sync_folder(path_.parent_path());
  } catch (...) {
    ::close(file_);
    throw;
  }
}

SettingsJournal::~SettingsJournal() {
  ::close(file_);
}

void SettingsJournal::append(const json& record, bool sync) const {
  const std::string line = record.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
  for (std::size_t done = 0; done < line.size();) {
    const ssize_t part = ::write(file_, line.data() + done, line.size() - done);
    if (part < 0 && errno == EINTR) continue;
    if (part <= 0) fail(path_, part < 0 ? errno : ENOSPC);
    done += static_cast<std::size_t>(part);
  }
  if (sync && ::fdatasync(file_) != 0) fail(path_, errno);
}

void SettingsJournal::intend(const DeviceRegister& place, const std::vector<std::uint16_t>& before,
                             const std::vector<std::uint16_t>& after) {
  append({{"write", place.name},
          {"address", place.describe_place()},
          {"old", before},
          {"new", after},
          {"time", describe_time_now()}},
         true);
}

void SettingsJournal::note(const json& record) noexcept {
  try {
    append(record, false);
  } catch (const std::exception&) {  // nothing depends on it
  }
}

void SettingsJournal::finish(DeviceState state) {
  append({{"state", name_of(state)}, {"time", describe_time_now()}}, true);
}

std::filesystem::path choose_journal_path(const std::string& device) {
  const std::filesystem::path folder = state_folder();
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) fail(folder, error.value());
  std::string name;
  for (const char c : device) name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  std::string time = describe_time_now();
  std::erase(time, ':');
  const std::string stem = fmt::format("{}-{}-{}", time, ::getpid(), name);
  std::filesystem::path path = folder / (stem + ".jsonl");
  for (int i = 2; std::filesystem::exists(path, error); ++i)
    path = folder / fmt::format("{}-{}.jsonl", stem, i);
  return path;
}

SettingsJournalContent read_settings_journal(const std::string& path) {
  const std::vector<json> lines = read_lines(path);
  const json& header = lines.front();
  SettingsJournalContent content;
  try {
    content.connect = header.at("connect");
    content.unit = header.at("unit");
    content.command = header.at("command");
    content.profile = parse_device_profile(header.at("profile_document"), path + ": profile");
    content.backup = parse_backup(header.at("backup"), content.profile, path + ": backup");
  } catch (const json::exception&) {
    throw Error(ErrorCode::bad_input, path, "its first line is not whole");
  }
  for (const json& line : lines) {
    if (line.contains("write")) content.written.push_back(line["write"]);
    if (line.contains("state")) content.state = line["state"].get<std::string>();
  }
  return content;
}

void close_settings_journal(const std::string& path) {
  read_lines(path);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): POSIX declares open() so
  const int file = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  // Behind a line that was torn.
  const std::string line =
      "\n" + json{{"state", "restored"}, {"time", describe_time_now()}}.dump() + "\n";
  const bool written =
      file >= 0 && ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size()) &&
      ::fdatasync(file) == 0;
  const int reason = errno;
  if (file >= 0) ::close(file);
  if (!written)
    throw Error(ErrorCode::bad_input, path,
                "cannot be written: " + std::generic_category().message(reason));
}

bool is_unfinished_journal(const std::string& path) {
  try {
    for (const json& line : read_lines(path))
      if (line.contains("state") && line["state"] != "unknown") return false;
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace gyrator
