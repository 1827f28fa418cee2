#include "gyrator/amplifiers/settings_journal.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/documents/output_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <fcntl.h>
#include <sstream>
#include <system_error>
#include <tuple>
#include <unistd.h>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr const char* restoring = "restoring";  // its backup is being put back

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

bool has_text(const json& record, const char* key) {
  const auto found = record.find(key);
  return found != record.end() && found->is_string();
}

bool is_header(const json& record) {
  return record.is_object() && has_text(record, "schema") &&
         record["schema"] == journal_schema_name;
}

struct Line {
  int number = 1;
  json record;
};

[[noreturn]] void refuse(const std::string& path, const Line& line, const std::string& message) {
  throw Error(ErrorCode::bad_input, fmt::format("{}: line {}", path, line.number), message);
}

// The lines that are whole; the first decides whether it is a journal at all.
std::vector<Line> read_lines(const std::string& path) {
  std::istringstream text(load_json_text(path));
  std::vector<Line> lines;
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    json record = json::parse(line, nullptr, false);
    if (record.is_discarded() || !record.is_object()) continue;
    lines.push_back({number, std::move(record)});
  }
  if (lines.empty() || !is_header(lines.front().record)) {
    throw Error(ErrorCode::bad_input, path,
                "is no journal of an amplifier's settings, which begins with \"schema\": "
                "\"gyrator/amplifier-journal/1\"");
  }
  return lines;
}

// The text of a line's member; empty where the line does not have it.
std::string take_text(const std::string& path, const Line& line, const char* key) {
  if (!line.record.contains(key)) return {};
  if (!has_text(line.record, key)) {
    refuse(path, line, fmt::format("\"{}\": {}: must be a text", key, line.record[key].dump()));
  }
  return line.record[key];
}

// Behind a line that was torn.
void append_state(const std::string& path, const char* state) {
  read_lines(path);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): POSIX declares open() so
  const int file = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  const std::string line =
      "\n" + json{{"state", state}, {"time", describe_time_now()}}.dump() + "\n";
  const bool written =
      file >= 0 && ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size()) &&
      ::fdatasync(file) == 0;
  const int reason = errno;
  if (file >= 0) ::close(file);
  if (!written)
    throw Error(ErrorCode::bad_input, path,
                "cannot be written: " + std::generic_category().message(reason));
}

// The last line with a state, found from the end: null without one.
json find_last_state(const std::string& text) {
  for (std::size_t end = text.size(); end > 0;) {
    const std::size_t before = text.rfind('\n', end - 1);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::string line = text.substr(begin, end - begin);
    if (line.find("\"state\"") != std::string::npos) {
      json record = json::parse(line, nullptr, false);
      if (record.is_object() && has_text(record, "state")) return record;
    }
    end = begin > 0 ? begin - 1 : 0;
  }
  return nullptr;
}

bool leaves_nothing(const json& end) {
  if (end.is_null()) return false;
  const std::string state = end["state"];
  if (state == name_of(DeviceState::unknown) || state == restoring) return false;
  return !(end.contains("restored") && end["restored"] == false);
}

std::optional<UnfinishedJournal> take_unfinished(const std::filesystem::path& path) {
  try {
    const std::string text = load_json_text(path);
    if (leaves_nothing(find_last_state(text))) return {};
    const json header = json::parse(text.substr(0, text.find('\n')), nullptr, false);
    // Of a restore that was cut off, the journal that it restores is the unfinished one.
    if (!is_header(header) || header.contains("restores")) return {};
    UnfinishedJournal found{name_journal(path), {}, {}, 0};
    if (has_text(header, "device")) found.device = header["device"];
    if (has_text(header, "time")) found.time = header["time"];
    if (header.contains("begun") && header["begun"].is_number_integer())
      found.begun = header["begun"];
    return found;
  } catch (const std::exception&) {  // not there, not readable, or none
    return {};
  }
}

std::string plain_name(const std::string& device) {
  std::string name;
  for (const char c : device) name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

// Of one device, by the names that choose_journal_path gives.
std::vector<std::filesystem::path> list_journals(const std::string& device) {
  constexpr std::size_t most = 200;
  const std::string name = "-" + plain_name(device);
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  for (std::filesystem::directory_iterator each(state_folder(), error), end; !error && each != end;
       each.increment(error)) {
    const std::filesystem::path& path = each->path();
    if (path.extension() == ".jsonl" && path.stem().string().find(name) != std::string::npos)
      paths.push_back(path);
  }
  std::sort(paths.rbegin(), paths.rend());  // the time comes first
  if (paths.size() > most) paths.resize(most);
  return paths;
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

void SettingsJournal::finish(DeviceState state, bool restored) {
  json end{{"state", name_of(state)}, {"time", describe_time_now()}};
  if (!restored) end["restored"] = false;
  append(end, true);
}

std::string name_journal(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path name =
      std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
  return error ? path.string() : name.string();
}

std::filesystem::path choose_journal_path(const std::string& device) {
  const std::filesystem::path folder = state_folder();
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) fail(folder, error.value());
  sync_folder(folder.parent_path());
  std::string time = describe_time_now();
  std::erase(time, ':');
  const std::string stem = fmt::format("{}-{}-{}", time, ::getpid(), plain_name(device));
  std::filesystem::path path = folder / (stem + ".jsonl");
  for (int i = 2; std::filesystem::exists(path, error); ++i)
    path = folder / fmt::format("{}-{}.jsonl", stem, i);
  return path;
}

SettingsJournalContent read_settings_journal(const std::string& path) {
  const std::vector<Line> lines = read_lines(path);
  const json& header = lines.front().record;
  SettingsJournalContent content;
  content.connect = take_text(path, lines.front(), "connect");
  content.command = take_text(path, lines.front(), "command");
  constexpr int most_units = 255;
  const json unit = header.value("unit", json(nullptr));
  if (!unit.is_number_integer() || unit < 0 || unit > most_units) {
    refuse(
        path, lines.front(),
        fmt::format("\"unit\": {}: must be a whole number from 0 to {}", unit.dump(), most_units));
  }
  content.unit = unit;
  for (const char* key : {"profile_document", "backup"})
    if (!header.contains(key)) refuse(path, lines.front(), fmt::format("\"{}\" is missing", key));
  content.profile = parse_device_profile(header["profile_document"], path + ": profile");
  content.backup = parse_backup(header["backup"], content.profile, path + ": backup");
  for (const Line& line : lines) {
    if (line.record.contains("write")) content.written.push_back(take_text(path, line, "write"));
    if (line.record.contains("state")) content.state = take_text(path, line, "state");
  }
  return content;
}

void reopen_settings_journal(const std::string& path) {
  append_state(path, restoring);
}

void close_settings_journal(const std::string& path) {
  append_state(path, "restored");
}

bool is_unfinished_journal(const std::string& path) {
  return take_unfinished(path).has_value();
}

std::vector<UnfinishedJournal> find_unfinished_journals(const std::string& device,
                                                        const std::vector<std::string>& known) {
  std::vector<std::filesystem::path> paths = list_journals(device);
  paths.insert(paths.end(), known.begin(), known.end());
  std::vector<UnfinishedJournal> found;
  for (const std::filesystem::path& path : paths) {
    std::optional<UnfinishedJournal> journal = take_unfinished(path);
    if (journal && journal->device == device) found.push_back(std::move(*journal));
  }
  const auto order = [](const UnfinishedJournal& each) {
    return std::tie(each.time, each.begun, each.path);
  };
  std::sort(found.begin(), found.end(),
            [&](const auto& a, const auto& b) { return order(a) < order(b); });
  const auto twice = std::unique(found.begin(), found.end(),
                                 [](const auto& a, const auto& b) { return a.path == b.path; });
  found.erase(twice, found.end());
  return found;
}

}  // namespace gyrator
