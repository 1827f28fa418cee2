#include "gyrator/modbus/modbus_link.hpp"

#include "gyrator/core/interrupt.hpp"
#include "gyrator/modbus/modbus_frame.hpp"

#include <chrono>
#include <csignal>

#include <gtest/gtest.h>

#include "support/mentions.hpp"
#include "support/modbus_bench.hpp"
#include "support/raw_modbus.hpp"
#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

using modbus_tests::FakeDevice;
using modbus_tests::fault_of;
using modbus_tests::quick_options;
using modbus_tests::ServedBank;
using passivity_tests::mentions;
using Fate = AnswerPlan::Fate;
using Words = std::vector<std::uint16_t>;

AnswerPlan with_fate(Fate fate) {
  AnswerPlan plan;
  plan.fate = fate;
  return plan;
}

AnswerPlan after(double delay) {
  AnswerPlan plan;
  plan.delay = delay;
  return plan;
}

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// What holds over both kinds of wire.
class EveryLink : public testing::TestWithParam<ServedBank::Wire> {
 protected:
  bool is_serial() const { return GetParam() == ServedBank::Wire::serial; }

  ServedBank served{GetParam()};
  ModbusLink link{served.address(), quick_options()};
};

INSTANTIATE_TEST_SUITE_P(Wires, EveryLink,
                         testing::Values(ServedBank::Wire::tcp, ServedBank::Wire::serial),
                         [](const auto& wire) {
                           return wire.param == ServedBank::Wire::tcp ? "Tcp" : "Serial";
                         });

TEST_P(EveryLink, ReadsAndWritesEveryTable) {
  EXPECT_EQ(link.read_registers(RegisterTable::input, 5, 3), (Words{36, 43, 50}));
  EXPECT_EQ(link.read_bits(RegisterTable::discrete, 0, 5), (std::vector<bool>{1, 0, 0, 1, 0}));
  link.write_registers(10, Words{1, 2, 3});
  link.write_registers(13, Words{4});
  EXPECT_EQ(link.read_registers(RegisterTable::holding, 9, 6), (Words{0, 1, 2, 3, 4, 0}));
  link.write_coil(7, true);
  link.write_coils(8, {true, false, true});
  EXPECT_EQ(link.read_bits(RegisterTable::coil, 6, 6), (std::vector<bool>{0, 1, 1, 0, 1, 0}));
  link.write_coil(7, false);
  EXPECT_FALSE(link.read_bits(RegisterTable::coil, 7, 1).front());
  EXPECT_EQ(served.bank.writes, 5);
  EXPECT_EQ(link.statistics().requests, 10U);
  EXPECT_EQ(link.statistics().writes, 5U);
  EXPECT_EQ(link.statistics().retries, 0U);
}

TEST_P(EveryLink, SplitsLongReads) {
  const Words words = link.read_registers(RegisterTable::input, 0, 200);
  EXPECT_EQ(words, served.bank.inputs);
  EXPECT_EQ(link.statistics().requests, 2U);
  LinkOptions options = quick_options();
  options.max_read = 30;
  ModbusLink careful(served.address(), options);
  EXPECT_EQ(careful.read_registers(RegisterTable::input, 0, 200), served.bank.inputs);
  EXPECT_EQ(careful.statistics().requests, 7U);
}

TEST_P(EveryLink, SaysExceptionsInWords) {
  const LinkError fault = fault_of([&] { link.read_registers(RegisterTable::holding, 300, 2); });
  EXPECT_EQ(fault.fault(), LinkFault::exception);
  EXPECT_EQ(fault.code(), ErrorCode::device);
  EXPECT_EQ(fault.exception(), ModbusException::illegal_data_address);
  EXPECT_TRUE(mentions(fault.what(), describe(served.address())));
  EXPECT_TRUE(mentions(fault.what(), "unit 1, holding 0x012C (40301)"));
  EXPECT_TRUE(mentions(fault.what(), "illegal data address (2): asked for function 3"));
  EXPECT_EQ(link.statistics().requests, 1U);  // asking again would not help
  EXPECT_EQ(link.read_registers(RegisterTable::input, 0, 1), Words{1});
}

TEST_P(EveryLink, ReadsAgainAfterEveryFault) {
  for (const Fate fate : {Fate::swallow, Fate::halve, Fate::garble, Fate::cut}) {
    served.plan({with_fate(fate), with_fate(fate)});
    EXPECT_EQ(link.read_registers(RegisterTable::input, 20, 2), (Words{141, 148}))
        << static_cast<int>(fate);
  }
  EXPECT_EQ(link.statistics().retries, 8U);
}

TEST_P(EveryLink, GivesUpAReadAfterItsRetries) {
  served.plan(std::vector<AnswerPlan>(20, with_fate(Fate::swallow)));
  LinkOptions options = quick_options();
  options.read_retries = 2;
  ModbusLink patient(served.address(), options);
  const double seconds = seconds_of([&] {
    const LinkError fault = fault_of([&] { patient.read_registers(RegisterTable::input, 0, 1); });
    EXPECT_EQ(fault.fault(), LinkFault::timeout);
    EXPECT_TRUE(mentions(fault.what(), "no answer within 0.15 s"));
  });
  EXPECT_EQ(served.bank.reads, 3);
  EXPECT_GE(seconds, 3 * 0.15);
  EXPECT_LT(seconds, 3 * 0.15 + 3);  // no more than a busy machine may add
  EXPECT_GE(patient.statistics().seconds, 3 * 0.15);
}

TEST_P(EveryLink, NeverSendsAWriteTwice) {
  int expected = 0;
  for (const Fate fate : {Fate::swallow, Fate::halve, Fate::garble, Fate::cut}) {
    for (int kind = 0; kind < 4; ++kind) {
      served.plan({with_fate(fate)});
      const LinkError fault = fault_of([&] {
        if (kind == 0) link.write_registers(1, Words{5});
        if (kind == 1) link.write_registers(1, Words{5, 6});
        if (kind == 2) link.write_coil(1, true);
        if (kind == 3) link.write_coils(1, {true, false});
      });
      EXPECT_NE(fault.fault(), LinkFault::exception);
      EXPECT_NE(fault.fault(), LinkFault::refused);
      EXPECT_TRUE(mentions(fault.what(), "read it back"));
      ++expected;
      // What is asked next gets its own answer, and nothing more is written.
      EXPECT_EQ(link.read_registers(RegisterTable::input, 3, 1), Words{22});
      EXPECT_EQ(served.bank.writes, expected) << static_cast<int>(fate) << ' ' << kind;
    }
  }
  EXPECT_EQ(link.statistics().writes, 16U);
}

TEST_P(EveryLink, TellsTheFaultsApart) {
  const auto fault_after = [&](Fate fate) {
    served.plan({with_fate(fate)});
    return fault_of([&] { link.write_registers(1, Words{5}); }).fault();
  };
  EXPECT_EQ(fault_after(Fate::swallow), LinkFault::timeout);
  EXPECT_EQ(fault_after(Fate::halve), LinkFault::timeout);
  EXPECT_EQ(fault_after(Fate::garble), LinkFault::garbled);
  EXPECT_EQ(fault_after(Fate::cut), is_serial() ? LinkFault::timeout : LinkFault::lost);
}

TEST_P(EveryLink, AsksABusyDeviceAgainButNotForAWrite) {
  served.refuse(ModbusException::device_busy, 2);
  EXPECT_EQ(link.read_registers(RegisterTable::input, 0, 1), Words{1});
  EXPECT_EQ(link.statistics().retries, 2U);
  EXPECT_EQ(link.statistics().exceptions, 2U);
  served.refuse(ModbusException::device_busy, 1);
  const LinkError fault = fault_of([&] { link.write_registers(0, Words{1}); });
  EXPECT_EQ(fault.exception(), ModbusException::device_busy);
  EXPECT_TRUE(mentions(fault.what(), "device busy (6)"));
  EXPECT_EQ(served.bank.writes, 0);
}

TEST_P(EveryLink, TakesNoLateAnswerForTheNextRequests) {
  LinkOptions options = quick_options(0.1);
  options.read_retries = 0;
  ModbusLink hasty(served.address(), options);
  for (int i = 0; i < 5; ++i) {
    // Late by less than what is waited for before the next request over a serial line.
    served.plan({after(0.12)});
    const LinkError fault = fault_of([&] { hasty.read_registers(RegisterTable::input, 0, 1); });
    EXPECT_EQ(fault.fault(), LinkFault::timeout);
    EXPECT_EQ(hasty.read_registers(RegisterTable::input, 10, 1), Words{71});
  }
}

TEST_P(EveryLink, KeepsTheGapBetweenRequests) {
  LinkOptions options = quick_options();
  options.gap = 0.03;
  ModbusLink slow(served.address(), options);
  const double seconds = seconds_of([&] {
    for (int i = 0; i < 6; ++i) slow.read_registers(RegisterTable::input, 0, 1);
  });
  EXPECT_GE(seconds, 5 * 0.03);
}

TEST_P(EveryLink, ConnectsAgainWhenTold) {
  link.disconnect();
  EXPECT_EQ(link.read_registers(RegisterTable::input, 0, 1), Words{1});
  link.reconnect();
  link.write_registers(0, Words{1});
  EXPECT_EQ(link.statistics().reconnects, 2U);
}

TEST_P(EveryLink, LogsEveryFrame) {
  const ScratchFolder folder;
  LinkOptions options = quick_options();
  options.wire_log = folder / "wire.log";
  ModbusLink logged(served.address(), options);
  logged.read_registers(RegisterTable::input, 2, 1);
  served.plan({with_fate(Fate::swallow)});
  fault_of([&] { logged.write_registers(1, Words{0xABCD}); });
  const std::string log = read_text(folder / "wire.log");
  EXPECT_TRUE(mentions(log, "connected"));
  EXPECT_TRUE(mentions(
      log, is_serial() ? "> 01 04 00 02 00 01 90 0A" : "> 00 01 00 00 00 06 01 04 00 02 00 01\n"));
  EXPECT_TRUE(
      mentions(log, is_serial() ? "< 01 04 02 00 0F" : "< 00 01 00 00 00 05 01 04 02 00 0F"));
  EXPECT_TRUE(mentions(log, "06 00 01 AB CD"));
  EXPECT_TRUE(mentions(log, "! no answer within 0.15 s"));
}

TEST_P(EveryLink, HasNoAnswerOfAUnitThatIsNotThere) {
  LinkOptions options = quick_options();
  options.unit = 9;
  options.read_retries = 0;
  ModbusLink other(served.address(), options);
  const LinkError fault = fault_of([&] { other.read_registers(RegisterTable::input, 0, 1); });
  EXPECT_TRUE(mentions(fault.what(), "unit 9"));
  if (is_serial()) {
    EXPECT_EQ(fault.fault(), LinkFault::timeout);
  } else {
    EXPECT_EQ(fault.exception(), ModbusException::gateway_target_failed);
  }
  EXPECT_EQ(served.bank.reads, 0);
}

TEST_P(EveryLink, RefusesWhatNoDeviceCanHave) {
  const auto is_refused = [](const std::function<void()>& work) {
    try {
      work();
    } catch (const LinkError&) {
      return false;
    } catch (const Error& error) {
      return error.code() == ErrorCode::bad_input;
    }
    return false;
  };
  EXPECT_TRUE(is_refused([&] { link.read_registers(RegisterTable::input, -1, 1); }));
  EXPECT_TRUE(is_refused([&] { link.read_registers(RegisterTable::input, 0, 0); }));
  EXPECT_TRUE(is_refused([&] { link.read_registers(RegisterTable::input, 65535, 2); }));
  EXPECT_TRUE(is_refused([&] { link.read_registers(RegisterTable::coil, 0, 1); }));
  EXPECT_TRUE(is_refused([&] { link.read_bits(RegisterTable::holding, 0, 1); }));
  EXPECT_TRUE(is_refused([&] { link.write_registers(0, Words{}); }));
  EXPECT_TRUE(is_refused([&] { link.write_registers(0, Words(124)); }));
  EXPECT_TRUE(is_refused([&] { link.write_coils(0, std::vector<bool>(1969)); }));
  EXPECT_TRUE(is_refused([&] { link.write_coil(65536, true); }));
  LinkOptions options;
  options.unit = 248;
  EXPECT_TRUE(is_refused([&] { ModbusLink(served.address(), options); }));
  options = {};
  options.response_timeout = 0;
  EXPECT_TRUE(is_refused([&] { ModbusLink(served.address(), options); }));
  options = {};
  options.max_read = 126;
  EXPECT_TRUE(is_refused([&] { ModbusLink(served.address(), options); }));
  options = {};
  options.unit = 0;
  EXPECT_EQ(is_refused([&] { ModbusLink(served.address(), options); }), is_serial());
}

TEST(Link, SaysThatNobodyIsThere) {
  std::uint16_t port = 0;
  { port = listen_for_tcp("127.0.0.1", 0, true).port; }
  const LinkError tcp = fault_of([&] { ModbusLink(TcpAddress{"127.0.0.1", port}); });
  EXPECT_EQ(tcp.fault(), LinkFault::refused);
  EXPECT_TRUE(mentions(tcp.what(), "refused"));
  const LinkError serial = fault_of([] { ModbusLink(SerialAddress{"/dev/no_such_tty"}); });
  EXPECT_EQ(serial.fault(), LinkFault::refused);
  EXPECT_TRUE(mentions(serial.what(), "No such file"));
}

TEST(Link, WritesOverANewConnectionWhereTheDeviceHasClosedTheOld) {
  auto first = std::make_unique<ServedBank>();
  ModbusLink link(first->address(), quick_options());
  link.write_registers(0, Words{1});
  const std::uint16_t port = first->port();
  first.reset();
  modbus_tests::CountingBank bank;
  ModbusServer second(bank);
  second.listen("127.0.0.1", port);
  std::thread serving([&] { second.run(); });
  link.write_registers(0, Words{2});
  second.stop();
  serving.join();
  EXPECT_EQ(bank.writes, 1);
  EXPECT_EQ(link.statistics().reconnects, 1U);
}

TEST(Link, SaysThatTheDeviceHasGone) {
  auto served = std::make_unique<ServedBank>();
  ModbusLink link(served->address(), quick_options());
  served.reset();
  const LinkError fault = fault_of([&] { link.write_registers(0, Words{2}); });
  EXPECT_EQ(fault.fault(), LinkFault::refused);
  EXPECT_EQ(link.statistics().requests, 0U);
}

/// The frame that a right device answers to a write of one register or a read of one.
Bytes right_answer(const Bytes& frame) {
  if (frame[7] == 6) return frame;
  return make_tcp_frame(read_word(frame, 0), frame[6], Bytes{frame[7], 2, 0x12, 0x34});
}

TEST(Link, TakesNothingForAnAnswerThatIsNone) {
  struct Mistake {
    const char* what;
    std::function<void(Bytes&)> make;
  };
  const std::vector<Mistake> mistakes{{"transaction", [](Bytes& frame) { frame[1] ^= 0x80U; }},
                                      {"protocol", [](Bytes& frame) { frame[3] = 1; }},
                                      {"announced", [](Bytes& frame) { frame[5] += 1; }},
                                      {"unit", [](Bytes& frame) { frame[6] += 1; }},
                                      {"function", [](Bytes& frame) { frame[7] ^= 1U; }},
                                      {"echo", [](Bytes& frame) { frame[9] += 1; }},
                                      {"echo", [](Bytes& frame) { frame.back() += 1; }}};
  for (const Mistake& mistake : mistakes) {
    FakeDevice device([&](const Bytes& frame) {
      Bytes answer = right_answer(frame);
      mistake.make(answer);
      return answer;
    });
    ModbusLink link(TcpAddress{"127.0.0.1", device.port()}, quick_options());
    const LinkError fault = fault_of([&] { link.write_registers(1, Words{5}); });
    EXPECT_EQ(fault.fault(), LinkFault::garbled) << fault.what();
    EXPECT_TRUE(mentions(fault.what(), mistake.what));
    EXPECT_EQ(device.requests(), 1);
  }
}

TEST(Link, FindsItsAnswerBehindRepeatedOnes) {
  Bytes last;
  FakeDevice device([&](const Bytes& frame) {
    Bytes answer = last;  // of the request before, once more
    last = right_answer(frame);
    answer.insert(answer.end(), last.begin(), last.end());
    answer.insert(answer.end(), last.begin(), last.end());
    return answer;
  });
  ModbusLink link(TcpAddress{"127.0.0.1", device.port()}, quick_options());
  for (int i = 0; i < 20; ++i) {
    link.write_registers(1, Words{5});
    EXPECT_EQ(link.read_registers(RegisterTable::holding, 1, 1), Words{0x1234});
  }
  EXPECT_EQ(link.statistics().retries, 0U);
  EXPECT_EQ(device.requests(), 40);
}

TEST(Link, BeginsANewConnectionAfterNonsense) {
  int asked = 0;
  FakeDevice device(
      [&](const Bytes& frame) { return ++asked < 3 ? Bytes(40, 0xA5) : right_answer(frame); });
  ModbusLink link(TcpAddress{"127.0.0.1", device.port()}, quick_options());
  EXPECT_EQ(link.read_registers(RegisterTable::holding, 1, 1), Words{0x1234});
  EXPECT_EQ(link.statistics().reconnects, 2U);
}

// Last of this file: the second SIGINT of a process ends it.
TEST(LinkInterrupt, EndsTheWaitBetweenTriesAndSendsNothingMore) {
  ServedBank served;
  LinkOptions options = quick_options();
  options.backoff = 60;
  ModbusLink link(served.address(), options);
  served.refuse(ModbusException::device_busy, 1000);
  install_interrupt_handler();
  std::thread user([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    std::raise(SIGINT);
  });
  const double seconds = seconds_of([&] {
    try {
      link.read_registers(RegisterTable::input, 0, 1);
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::interrupted);
    }
    EXPECT_THROW(link.write_registers(0, Words{1}), Error);
  });
  user.join();
  EXPECT_LT(seconds, 5);
  EXPECT_EQ(link.statistics().requests, 1U);
  acknowledge_interrupt();
  served.refuse(ModbusException::device_busy, 0);
  link.write_registers(0, Words{1});  // making the device safe is still possible
  EXPECT_EQ(served.bank.writes, 1);
}

}  // namespace
}  // namespace gyrator
