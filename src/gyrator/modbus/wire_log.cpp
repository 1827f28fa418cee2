#include "gyrator/modbus/wire_log.hpp"

#include "gyrator/core/error.hpp"

#include <chrono>
#include <ctime>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

std::string format_now() {
  using namespace std::chrono;
  const auto now = duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
  constexpr std::int64_t per_second = 1000000;
  const std::time_t seconds = now / per_second;
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z", utc.tm_year + 1900,
                     utc.tm_mon + 1, utc.tm_mday, utc.tm_hour, utc.tm_min, utc.tm_sec,
                     now % per_second);
}

}  // namespace

WireLog::WireLog(const std::filesystem::path& path, std::string address)
    : address_(std::move(address)) {
  if (path.empty()) return;
  file_.open(path, std::ios::app);
  if (!file_)
    throw Error(ErrorCode::bad_input, path.string(), "cannot be written: the log of the wire");
}

void WireLog::write(char direction, ByteSpan frame) {
  if (!file_.is_open()) return;
  file_ << format_now() << ' ' << address_ << ' ' << direction << ' ' << format_hex(frame)
        << std::endl;  // at once: the log is read when something went wrong
}

void WireLog::note(std::string_view event) {
  if (!file_.is_open()) return;
  file_ << format_now() << ' ' << address_ << " ! " << event << std::endl;
}

}  // namespace gyrator
