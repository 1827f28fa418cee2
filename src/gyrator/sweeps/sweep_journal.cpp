#include "gyrator/sweeps/sweep_journal.hpp"

#include "gyrator/core/bytes.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/documents/output_file.hpp"

#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <boost/crc.hpp>
#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr std::string_view magic = "gsj1";
constexpr std::size_t frame_bytes = 12;  // magic, length, CRC
constexpr const char* journal_schema = "gyrator/sweep-journal/1";

std::uint32_t compute_crc(std::string_view bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

// The payload of the record at the start; none where it is torn.
std::optional<std::string_view> find_record(std::string_view bytes) {
  if (bytes.size() < frame_bytes || !bytes.starts_with(magic)) return std::nullopt;
  ByteReader frame(bytes.substr(magic.size(), frame_bytes - magic.size()));
  const auto length = frame.take<std::uint32_t>();
  const auto crc = frame.take<std::uint32_t>();
  if (bytes.size() - frame_bytes < length) return std::nullopt;
  const std::string_view payload = bytes.substr(frame_bytes, length);
  if (compute_crc(payload) != crc) return std::nullopt;
  return payload;
}

std::string read_bytes(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

json make_header(const SweepPlan& plan) {
  return {{"schema", journal_schema},
          {"digest", plan.digest()},
          {"identity", plan.identity()},
          {"model_file", plan.study().model_file},
          {"model", plan.study().model_text}};
}

// Which part of the study is another, of two that have different digests.
std::string describe_difference(const json& kept, const json& asked) {
  if (kept["model_sha256"] != asked["model_sha256"]) return "its model has another text";
  if (kept["files"] != asked["files"])
    return "a file that its model names, or that such a file includes, has another content";
  if (kept["program"] != asked["program"])
    return "it was begun by " + kept["program"].get<std::string>();
  for (const auto& [key, what] : {std::pair{"analysis", "its analysis is another"},
                                  std::pair{"vary", "other values vary in it"},
                                  std::pair{"sampling", "its points are sampled otherwise"},
                                  std::pair{"model", "its model is another file"}}) {
    if (kept["study"][key] != asked["study"][key]) return what;
  }
  return "it differs";
}

// Puts all whole chunks behind the header into the store; how many bytes they take.
std::size_t read_chunks(std::string_view bytes, std::size_t outputs, SweepStore& store) {
  std::size_t read = 0;
  while (const auto payload = find_record(bytes.substr(read))) {
    store.add(read_chunk_bytes(*payload, outputs));
    read += frame_bytes + payload->size();
  }
  return read;
}

template <class Function>
auto naming(const std::string& path, const Function& read) {
  try {
    return read();
  } catch (const Error& error) {
    if (!error.place().empty()) throw;
    throw Error(error.code(), path, error.message());
  }
}

}  // namespace

std::string journal_name(const std::string& result) {
  return result + ".journal";
}

SweepJournal::SweepJournal(std::string path, const SweepPlan& plan, SweepStore& store, bool restart)
    : path_(std::move(path)) {
  try {
    // A run that ended in between has removed the file that was opened.
    while (!open_locked()) ::close(std::exchange(file_, -1));
    resume(plan, store, restart);
  } catch (...) {
    if (file_ >= 0) ::close(file_);
    throw;
  }
}

bool SweepJournal::open_locked() {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): POSIX declares open() so
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file_ < 0) fail(errno);
  if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    throw Error(ErrorCode::bad_input, path_,
                "another run is working on it: wait for its end, or give this one a result file "
                "of its own (-o)");
  }
  struct stat locked {};
  struct stat named {};
  if (::fstat(file_, &locked) != 0) fail(errno);
  return ::stat(path_.c_str(), &named) == 0 && named.st_ino == locked.st_ino &&
         named.st_dev == locked.st_dev;
}

SweepJournal::~SweepJournal() {
  ::close(file_);
}

void SweepJournal::fail(int reason) const {
  throw Error(ErrorCode::bad_input, path_,
              "cannot be written: " + std::generic_category().message(reason));
}

void SweepJournal::begin(const SweepPlan& plan) {
  if (::ftruncate(file_, 0) != 0) fail(errno);
  write_record(make_header(plan).dump(-1, ' ', false, json::error_handler_t::replace));
  sync_folder(std::filesystem::path(path_).parent_path());
}

void SweepJournal::resume(const SweepPlan& plan, SweepStore& store, bool restart) {
  const std::string bytes = read_bytes(path_);
  const auto header = find_record(bytes);
  // Not even the header was written whole: nothing is lost.
  const std::string_view start = std::string_view(bytes).substr(0, magic.size());
  const bool begun_at_most = !header && magic.starts_with(start);
  if (begun_at_most || (header && restart)) return begin(plan);
  if (!header) {
    throw Error(ErrorCode::bad_input, path_,
                "is no journal of a sweep, and stands where this one's belongs: move it away, or "
                "give another result file (-o)");
  }
  const json kept = json::parse(*header);
  if (kept.at("digest") != plan.digest()) {
    throw Error(ErrorCode::bad_input, path_,
                fmt::format("holds the results of another study: {}. Finish that one first, give "
                            "this one a result file of its own (-o), or throw them away with "
                            "--restart",
                            describe_difference(kept.at("identity"), plan.identity())));
  }
  const std::size_t head = frame_bytes + header->size();
  const std::size_t chunks = naming(path_, [&] {
    return read_chunks(std::string_view(bytes).substr(head), plan.outputs().size(), store);
  });
  if (::ftruncate(file_, static_cast<off_t>(head + chunks)) != 0) fail(errno);
}

void SweepJournal::append(const ChunkResult& result) {
  if (!result.points.empty()) write_record(write_chunk_bytes(result));
}

void SweepJournal::write_record(std::string_view payload) {
  ByteWriter frame;
  frame.put(static_cast<std::uint32_t>(payload.size()));
  frame.put(compute_crc(payload));
  const std::string record = std::string(magic) + frame.bytes() + std::string(payload);
  for (std::size_t at = 0; at < record.size();) {
    const ssize_t written = ::write(file_, record.data() + at, record.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    at += static_cast<std::size_t>(written);
  }
  if (::fdatasync(file_) != 0) fail(errno);
}

void SweepJournal::remove() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
  sync_folder(std::filesystem::path(path_).parent_path());
}

bool is_journal(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string start(magic.size(), '\0');
  stream.read(start.data(), static_cast<std::streamsize>(start.size()));
  return stream.gcount() == static_cast<std::streamsize>(magic.size()) && start == magic;
}

JournalContent read_journal(const std::string& path) {
  const std::string bytes = read_bytes(path);
  const auto header = find_record(bytes);
  if (!header) throw Error(ErrorCode::bad_input, path, "is no journal of a sweep");
  const json kept = json::parse(*header);
  SweepStudy study = parse_study(kept.at("identity").at("study"), path);
  study.model_file = kept.at("model_file");
  study.model_text = kept.at("model");
  SweepPlan plan(std::move(study));
  SweepStore store(plan.size(), plan.outputs().size());
  naming(path, [&] {
    return read_chunks(std::string_view(bytes).substr(frame_bytes + header->size()),
                       plan.outputs().size(), store);
  });
  return {std::move(plan), std::move(store)};
}

}  // namespace gyrator
