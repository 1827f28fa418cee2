#include "gyrator/studies/progress.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sys/ioctl.h>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

namespace gyrator {
namespace {

constexpr auto patience = std::chrono::seconds(1);  // shorter work shows no bar
constexpr auto redraw_after = std::chrono::milliseconds(100);

std::size_t terminal_width() {
  winsize size{};
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): POSIX declares ioctl() so
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 20) return 80;
  return size.ws_col;
}

std::string clock_text(double seconds) {
  const auto whole = static_cast<long long>(std::ceil(std::min(seconds, 3.6e6)));
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace

Progress::Progress(std::string title, std::uint64_t total, bool quiet)
    : title_(std::move(title)),
      total_(total),
      visible_(!quiet && ::isatty(STDERR_FILENO) == 1),
      next_draw_((start_ + patience).time_since_epoch().count()) {}

Progress::~Progress() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void Progress::advance(std::uint64_t steps) {
  const std::uint64_t done = done_.fetch_add(steps) + steps;
  if (!visible_) return;
  const auto now = Clock::now();
  if (now.time_since_epoch().count() < next_draw_.load()) return;
  // Whoever finds another thread drawing goes back to work.
  const std::unique_lock lock(drawing_, std::try_to_lock);
  if (lock.owns_lock()) draw(done, now);
}

void Progress::draw(std::uint64_t done, Clock::time_point now) {
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const auto line = progress_line(title_, done, total_, elapsed_s, terminal_width() - 1);
  std::fputs(("\r" + line + "\033[K").c_str(), stderr);
  std::fflush(stderr);
  next_draw_.store((now + redraw_after).time_since_epoch().count());
  drawn_ = true;
}

std::string progress_line(const std::string& title, std::uint64_t done, std::uint64_t total,
                          double elapsed_s, std::size_t width) {
  const double rate = elapsed_s > 0 ? static_cast<double>(done) / elapsed_s : 0.0;
  std::string line;
  if (total == 0) {
    line = fmt::format("{}  {}  {:.3g}/s", title, done, rate);
  } else {
    const double part = std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
    const auto left_s = rate > 0 ? static_cast<double>(total) * (1.0 - part) / rate : 0.0;
    const auto numbers = fmt::format("{:3.0f} %  {:.3g}/s  {} left", std::floor(100 * part), rate,
                                     rate > 0 ? clock_text(left_s) : std::string("?"));
    // The bar takes what the words leave over, up to 30 columns, and goes first.
    const std::size_t words = title.size() + numbers.size() + 6;
    const std::size_t bar = width > words ? std::min<std::size_t>(30, width - words) : 0;
    if (bar >= 5) {
      const auto filled = static_cast<std::size_t>(std::floor(part * static_cast<double>(bar)));
      line = fmt::format("{}  [{}{}]  {}", title, std::string(filled, '#'),
                         std::string(bar - filled, ' '), numbers);
    } else {
      line = fmt::format("{}  {}", title, numbers);
    }
  }
  return line.substr(0, width);
}

}  // namespace gyrator
