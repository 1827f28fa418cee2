#include "gyrator/modbus/link_address.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/modbus/serial_line.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <modbus/modbus.h>
#include <termios.h>

#include <gtest/gtest.h>

#include "support/mentions.hpp"
#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

using passivity_tests::mentions;

std::string refusal_of(const std::string& text) {
  try {
    parse_link_address(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.what();
  }
  ADD_FAILURE() << text << " was taken";
  return "";
}

TEST(LinkAddress, ReadsWhatItWrites) {
  for (const char* text : {"tcp://127.0.0.1:1502", "tcp://drive.local:502", "tcp://[::1]:1502",
                           "rtu:///dev/ttyUSB0?baud=115200&parity=N&stop=2",
                           "rtu:///dev/serial/by-id/usb-0?baud=9600&parity=O&stop=1"})
    EXPECT_EQ(describe(parse_link_address(text)), text);
}

TEST(LinkAddress, WhatIsNotSaidIsAsTheSpecificationHasIt) {
  EXPECT_EQ(describe(parse_link_address("tcp://127.0.0.1")), "tcp://127.0.0.1:502");
  EXPECT_EQ(describe(parse_link_address("rtu:///dev/ttyS1")),
            "rtu:///dev/ttyS1?baud=19200&parity=E&stop=1");
  EXPECT_EQ(describe(parse_link_address("tcp://[fe80::1]")), "tcp://[fe80::1]:502");
}

TEST(LinkAddress, RefusesOthersWithWhatIsAllowed) {
  for (const char* text : {"", "127.0.0.1:502", "tcp://", "tcp://:502", "tcp://a:", "tcp://[::1",
                           "tcp://[::1]x", "tcp://a b:1", "rtu://", "udp://a:1"})
    EXPECT_FALSE(refusal_of(text).empty());
  EXPECT_TRUE(mentions(refusal_of("127.0.0.1:502"), "tcp://HOST:PORT"));
  EXPECT_TRUE(mentions(refusal_of("tcp://a:0"), "from 1 to 65535"));
  EXPECT_TRUE(mentions(refusal_of("tcp://a:65536"), "from 1 to 65535"));
  EXPECT_TRUE(mentions(refusal_of("tcp://a:5o2"), "5o2"));
  EXPECT_TRUE(mentions(refusal_of("rtu:///dev/ttyS0?baud=250000"), "115200"));
  EXPECT_TRUE(mentions(refusal_of("rtu:///dev/ttyS0?parity=e"), "N, E, O"));
  EXPECT_TRUE(mentions(refusal_of("rtu:///dev/ttyS0?stop=3"), "1, 2"));
  EXPECT_TRUE(mentions(refusal_of("rtu:///dev/ttyS0?bauds=9600"), "did you mean 'baud'"));
}

/// Output speed that libmodbus sets a terminal to.
speed_t speed_by_libmodbus(const std::string& terminal, int baud) {
  modbus_t* context = ::modbus_new_rtu(terminal.c_str(), baud, 'E', 8, 1);
  EXPECT_EQ(::modbus_connect(context), 0);
  termios settings{};
  ::tcgetattr(::modbus_get_socket(context), &settings);
  ::modbus_close(context);
  ::modbus_free(context);
  return ::cfgetospeed(&settings);
}

TEST(LinkAddress, LibmodbusSetsEveryBaudRateThatIsAllowed) {
  const PseudoTerminal terminal;
  const speed_t fallback = speed_by_libmodbus(terminal.name(), 250000);
  EXPECT_EQ(fallback, B9600);  // what refusing unknown rates is for
  for (const int baud : known_baud_rates()) {
    const FileDescriptor ours = open_serial_line({terminal.name(), baud, Parity::even, 1});
    termios settings{};
    ::tcgetattr(ours.get(), &settings);
    EXPECT_EQ(speed_by_libmodbus(terminal.name(), baud), ::cfgetospeed(&settings)) << baud;
    EXPECT_EQ(::cfgetospeed(&settings) == B9600, baud == 9600) << baud;
  }
}

TEST(LinkAddress, WireTimesAreThoseOfElevenBitsACharacter) {
  const SerialAddress slow{"", 9600, Parity::even, 1}, fast{"", 115200, Parity::even, 1};
  EXPECT_DOUBLE_EQ(compute_character_time(slow), 11 / 9600.0);
  EXPECT_DOUBLE_EQ(compute_character_time({"", 9600, Parity::none, 2}), 11 / 9600.0);
  EXPECT_DOUBLE_EQ(compute_character_time({"", 9600, Parity::none, 1}), 10 / 9600.0);
  EXPECT_DOUBLE_EQ(compute_frame_gap(slow), 3.5 * 11 / 9600);
  EXPECT_DOUBLE_EQ(compute_frame_gap({"", 19200, Parity::even, 1}), 3.5 * 11 / 19200);
  EXPECT_DOUBLE_EQ(compute_frame_gap(fast), 1.75e-3);
  // Ten registers: 8 bytes there, 5 + 20 back.
  EXPECT_NEAR(1 / compute_wire_time(slow, 8, 25), 22, 0.5);
  EXPECT_NEAR(1 / compute_wire_time(fast, 8, 25), 150, 2);
}

TEST(PseudoTerminal, IsLinkedWhileItLives) {
  const ScratchFolder folder;
  const auto link = folder / "tty";
  {
    const PseudoTerminal terminal(link);
    EXPECT_EQ(std::filesystem::read_symlink(link), terminal.name());
    const PseudoTerminal second(folder / "other");
    EXPECT_NE(second.name(), terminal.name());
  }
  EXPECT_EQ(folder.count(), 0U);
}

TEST(PseudoTerminal, ReplacesALinkLeftBehindAndNothingElse) {
  const ScratchFolder folder;
  std::filesystem::create_symlink("/dev/pts/999999", folder / "stale");
  { const PseudoTerminal terminal(folder / "stale"); }
  EXPECT_EQ(folder.count(), 0U);
  std::ofstream(folder / "file") << "precious";
  EXPECT_THROW(PseudoTerminal(folder / "file"), Error);
  EXPECT_EQ(read_text(folder / "file"), "precious");
  std::filesystem::create_symlink(folder / "file", folder / "own");
  EXPECT_THROW(PseudoTerminal(folder / "own"), Error);
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "own"));
}

}  // namespace
}  // namespace gyrator
