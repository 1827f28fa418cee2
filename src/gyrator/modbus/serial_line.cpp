#include "gyrator/modbus/serial_line.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <system_error>
#include <termios.h>
#include <utility>

namespace gyrator {
namespace {

namespace fs = std::filesystem;

constexpr const char* terminals_folder = "/dev/pts";

struct Speed {
  int baud;
  speed_t code;
};

constexpr std::array speeds{
    Speed{110, B110},         Speed{300, B300},         Speed{600, B600},
    Speed{1200, B1200},       Speed{2400, B2400},       Speed{4800, B4800},
    Speed{9600, B9600},       Speed{19200, B19200},     Speed{38400, B38400},
    Speed{57600, B57600},     Speed{115200, B115200},   Speed{230400, B230400},
    Speed{460800, B460800},   Speed{500000, B500000},   Speed{576000, B576000},
    Speed{921600, B921600},   Speed{1000000, B1000000}, Speed{1152000, B1152000},
    Speed{1500000, B1500000}, Speed{2500000, B2500000}, Speed{3000000, B3000000},
    Speed{3500000, B3500000}, Speed{4000000, B4000000}};

[[noreturn]] void fail(const std::string& place, const std::string& what) {
  throw Error(ErrorCode::device, place, what + ": " + std::generic_category().message(errno));
}

void make_raw(termios& settings) {
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
}

void set_line(termios& settings, const SerialAddress& line) {
  make_raw(settings);
  settings.c_cflag &= ~static_cast<tcflag_t>(PARENB | PARODD | CSTOPB | CRTSCTS);
  const bool parity = line.parity != Parity::none && !is_pseudo_terminal(line.device);
  if (parity) settings.c_cflag |= PARENB;
  if (parity && line.parity == Parity::odd) settings.c_cflag |= PARODD;
  if (line.stop_bits == 2) settings.c_cflag |= CSTOPB;
  const auto* speed = std::find_if(speeds.begin(), speeds.end(),
                                   [&](const Speed& s) { return s.baud == line.baud; });
  if (speed == speeds.end())
    throw Error(ErrorCode::bad_input, line.device,
                std::to_string(line.baud) + " baud is not a rate that serial drivers know");
  ::cfsetispeed(&settings, speed->code);
  ::cfsetospeed(&settings, speed->code);
}

std::string terminal_name(int descriptor) {
  std::array<char, 64> name{};
  if (::ptsname_r(descriptor, name.data(), name.size()) != 0)
    fail("pseudo-terminal", "has no name");
  return name.data();
}

/// What an ended server has left behind is a link to a pseudo-terminal.
void make_room_for(const fs::path& link) {
  std::error_code ignored;
  const fs::file_status status = fs::symlink_status(link, ignored);
  if (!fs::exists(status)) return;
  const fs::path target = fs::is_symlink(status) ? fs::read_symlink(link, ignored) : fs::path();
  if (target.parent_path() != terminals_folder)
    throw Error(ErrorCode::bad_input, link.string(),
                "exists already: the link to the pseudo-terminal needs a name of its own");
  fs::remove(link, ignored);
}

}  // namespace

const std::vector<int>& known_baud_rates() {
  static const std::vector<int> rates = [] {
    std::vector<int> found;
    found.reserve(speeds.size());
    for (const Speed& speed : speeds) found.push_back(speed.baud);
    return found;
  }();
  return rates;
}

bool is_pseudo_terminal(const std::string& device) {
  std::error_code ignored;
  return fs::canonical(device, ignored).parent_path() == terminals_folder;
}

FileDescriptor open_serial_line(const SerialAddress& line) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): open() is one
  FileDescriptor port(::open(line.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!port.is_open()) fail(line.device, "cannot be opened");
  termios settings{};
  if (::tcgetattr(port.get(), &settings) != 0) fail(line.device, "is not a serial line");
  set_line(settings, line);
  if (::tcsetattr(port.get(), TCSANOW, &settings) != 0)
    fail(line.device, "does not take the settings of the line");
  return port;
}

PseudoTerminal::PseudoTerminal(fs::path link)
    : ours_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
  if (!ours_.is_open() || ::grantpt(ours_.get()) != 0 || ::unlockpt(ours_.get()) != 0)
    fail("pseudo-terminal", "none could be had");
  name_ = terminal_name(ours_.get());
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg)
  held_ = FileDescriptor(::open(name_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (!held_.is_open() || ::tcgetattr(held_.get(), &settings) != 0) fail(name_, "cannot be opened");
  make_raw(settings);
  ::tcsetattr(held_.get(), TCSANOW, &settings);
  if (link.empty()) return;
  make_room_for(link);
  std::error_code refused;
  fs::create_symlink(name_, link, refused);
  if (refused)
    throw Error(ErrorCode::bad_input, link.string(),
                "cannot be made a link to " + name_ + ": " + refused.message());
  link_ = std::move(link);
}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  if (!link_.empty() && fs::read_symlink(link_, ignored) == name_) fs::remove(link_, ignored);
}

}  // namespace gyrator
