#include "gyrator/modbus/modbus_server.hpp"

#include "gyrator/modbus/modbus_frame.hpp"

#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "support/mentions.hpp"
#include "support/modbus_bench.hpp"
#include "support/raw_modbus.hpp"
#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

using modbus_tests::CountingBank;
using modbus_tests::RawClient;
using modbus_tests::ServedBank;
using passivity_tests::mentions;

const Bytes read_one = make_read_request(RegisterTable::input, 2, 1);
const Bytes one_read{0x04, 0x02, 0x00, 0x0F};
constexpr double silence = 0.2;  // [s], ten times what ends a frame

TEST(TcpServer, AnswersItsUnitAndTheOnesThatMeanTheDevice) {
  const ServedBank served;
  const RawClient client(served.port());
  for (const std::uint8_t unit : Bytes{1, 0, 255}) {
    client.send(make_tcp_frame(0x1234, unit, read_one));
    EXPECT_EQ(client.receive(11), make_tcp_frame(0x1234, unit, one_read));
  }
  client.send(make_tcp_frame(7, 2, read_one));
  EXPECT_EQ(client.receive(9), make_tcp_frame(7, 2, Bytes{0x84, 11}));
  EXPECT_EQ(served.bank.reads, 3);
}

TEST(TcpServer, TakesFramesInPiecesAndManyAtOnce) {
  const ServedBank served;
  const RawClient client(served.port());
  for (const std::uint8_t byte : make_tcp_frame(1, 1, read_one)) client.send({byte});
  EXPECT_EQ(client.receive(11), make_tcp_frame(1, 1, one_read));
  Bytes many, expected;
  for (std::uint16_t i = 0; i < 50; ++i) {
    for (const auto byte : make_tcp_frame(i, 1, read_one)) many.push_back(byte);
    for (const auto byte : make_tcp_frame(i, 1, one_read)) expected.push_back(byte);
  }
  client.send(many);
  EXPECT_EQ(client.receive(expected.size()), expected);
}

TEST(TcpServer, HangsUpOnWhatIsNoModbusAndServesTheOthers) {
  const ServedBank served;
  const RawClient good(served.port());
  for (const Bytes& wrong : {
           Bytes{0, 1, 0, 9, 0, 6, 1, 3, 0, 0, 0, 1},   // protocol 9
           Bytes{0, 1, 0, 0, 0, 1, 1, 3, 0, 0, 0, 1},   // too short to have a function
           Bytes{0, 1, 0, 0, 0, 255, 1, 3, 0, 0, 0, 1}  // longer than a frame may be
       }) {
    const RawClient bad(served.port());
    bad.send(wrong);
    EXPECT_TRUE(bad.is_closed());
  }
  good.send(make_tcp_frame(1, 1, read_one));
  EXPECT_EQ(good.receive(11).size(), 11U);
}

TEST(TcpServer, SurvivesRandomBytes) {
  ServerOptions options;
  options.most_clients = 400;  // it need not have noticed yet that the others have gone
  const ServedBank served(ServedBank::Wire::tcp, options);
  std::mt19937 random(5);
  for (int i = 0; i < 300; ++i) {
    const RawClient client(served.port());
    Bytes noise(random() % 400);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
    if (random() % 2 == 0 && noise.size() > 8) {  // with a header that lets it through
      const Bytes header = make_tcp_frame(1, 1, Bytes(noise.size() % 250 + 1));
      std::copy(header.begin(), header.begin() + 7, noise.begin());
    }
    client.send(noise);
  }
  const RawClient client(served.port());
  client.send(make_tcp_frame(1, 1, read_one));
  EXPECT_EQ(client.receive(11), make_tcp_frame(1, 1, one_read));
}

TEST(TcpServer, ServesClientsWhileAnotherWaitsForItsLateAnswer) {
  ServedBank served;
  const RawClient slow(served.port()), quick(served.port());
  AnswerPlan late;
  late.delay = 0.3;
  served.plan({late});
  slow.send(make_tcp_frame(1, 1, read_one));
  const auto begin = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  while (served.bank.reads == 0 && seconds() < 2) std::this_thread::yield();
  quick.send(make_tcp_frame(2, 1, read_one));
  EXPECT_EQ(quick.receive(11), make_tcp_frame(2, 1, one_read));
  EXPECT_EQ(slow.receive(1, 0).size(), 0U);
  EXPECT_EQ(slow.receive(11), make_tcp_frame(1, 1, one_read));
  EXPECT_GE(seconds(), 0.29);
}

TEST(TcpServer, TurnsAwayMoreClientsThanItMayHave) {
  ServerOptions options;
  options.most_clients = 2;
  const ServedBank served(ServedBank::Wire::tcp, options);
  auto first = std::make_unique<RawClient>(served.port());
  const RawClient second(served.port());
  second.send(make_tcp_frame(1, 1, read_one));
  EXPECT_EQ(second.receive(11).size(), 11U);
  const RawClient third(served.port());
  EXPECT_TRUE(third.is_closed());
  first.reset();
  second.send(make_tcp_frame(1, 1, read_one));
  EXPECT_EQ(second.receive(11).size(), 11U);
  const RawClient fourth(served.port());
  fourth.send(make_tcp_frame(1, 1, read_one));
  EXPECT_EQ(fourth.receive(11).size(), 11U);
}

TEST(TcpServer, ListensToThisMachineAloneUnlessToldOtherwise) {
  CountingBank bank;
  ModbusServer server(bank);
  try {
    server.listen("0.0.0.0", 0);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_TRUE(mentions(error.what(), "127.0.0.1"));
  }
  const std::uint16_t port = server.listen("127.0.0.1", 0);
  EXPECT_GT(port, 0);
  try {
    server.listen("127.0.0.1", port);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::device);
  }
  EXPECT_THROW(server.listen("no such host.invalid", 0), Error);
  ServerOptions open;
  open.loopback_only = false;
  ModbusServer public_server(bank, open);
  EXPECT_GT(public_server.listen("0.0.0.0", 0), 0);
}

TEST(TcpServer, HooksSeeWhatGoesOverTheWire) {
  CountingBank bank;
  std::vector<std::size_t> sizes;
  ServerHooks hooks;
  hooks.before_request = [](std::span<const std::uint8_t> request) {
    return request[0] == 6 ? std::optional(ModbusException::device_busy) : std::nullopt;
  };
  hooks.before_answer = [&](const ServerExchange& exchange) {
    sizes = {exchange.request.size(), exchange.answer.size(), exchange.request_bytes,
             exchange.answer_bytes};
    AnswerPlan plan;
    if (exchange.request[0] == 3) plan.other_answer = Bytes{0x83, 4};
    return plan;
  };
  ModbusServer server(bank, {}, hooks);
  const RawClient client(server.listen("127.0.0.1", 0));
  const auto ask = [&](const Bytes& request, std::size_t answer_bytes) {
    client.send(make_tcp_frame(1, 1, request));
    for (int i = 0; i < 3; ++i) server.poll(0.05);
    return client.receive(answer_bytes);
  };
  EXPECT_EQ(ask(read_one, 11), make_tcp_frame(1, 1, one_read));
  EXPECT_EQ(sizes, (std::vector<std::size_t>{5, 4, 12, 11}));
  EXPECT_EQ(ask(make_register_request(1, 1), 9), make_tcp_frame(1, 1, Bytes{0x86, 6}));
  EXPECT_EQ(bank.writes, 0);
  EXPECT_EQ(ask(make_read_request(RegisterTable::holding, 0, 1), 9),
            make_tcp_frame(1, 1, Bytes{0x83, 4}));
}

TEST(SerialServer, AnswersItsUnitAndIsSilentForOthers) {
  const ServedBank served(ServedBank::Wire::serial);
  const RawClient client(served.terminal());
  client.send(make_serial_frame(1, read_one));
  EXPECT_EQ(client.receive(7), make_serial_frame(1, one_read));
  client.send(make_serial_frame(2, read_one));
  // The other unit's answer passes by too, and is no request.
  client.send(make_serial_frame(2, one_read));
  EXPECT_TRUE(client.receive(1, silence).empty());
  EXPECT_EQ(served.bank.reads, 1);
  client.send(make_serial_frame(1, read_one));
  EXPECT_EQ(client.receive(7), make_serial_frame(1, one_read));
}

TEST(SerialServer, DoesBroadcastsWithoutAnAnswer) {
  const ServedBank served(ServedBank::Wire::serial);
  const RawClient client(served.terminal());
  client.send(make_serial_frame(0, make_register_request(3, 77)));
  EXPECT_TRUE(client.receive(1, silence).empty());
  EXPECT_EQ(served.bank.holdings[3], 77);
}

TEST(SerialServer, FindsTheNextFrameAfterAGapOfSilence) {
  const ServedBank served(ServedBank::Wire::serial);
  const RawClient client(served.terminal());
  const Bytes good = make_serial_frame(1, read_one);
  const Bytes half(good.begin(), good.begin() + 5);
  Bytes wrong_sum = good;
  wrong_sum.back() ^= 1U;
  std::mt19937 random(1);
  Bytes noise(5000);
  for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
  for (const Bytes& garbage : {half, wrong_sum, Bytes{0xFF}, noise}) {
    client.send(garbage);
    EXPECT_TRUE(client.receive(1, silence).empty());
    client.send(good);
    EXPECT_EQ(client.receive(7), make_serial_frame(1, one_read));
  }
}

TEST(SerialServer, TakesFramesInPiecesAndUnknownFunctionsAtTheGap) {
  const ServedBank served(ServedBank::Wire::serial);
  const RawClient client(served.terminal());
  for (const std::uint8_t byte : make_serial_frame(1, read_one)) client.send({byte});
  EXPECT_EQ(client.receive(7), make_serial_frame(1, one_read));
  client.send(make_serial_frame(1, Bytes{0x2B, 0x0E, 0x01, 0x00}));
  EXPECT_EQ(client.receive(5), make_serial_frame(1, Bytes{0xAB, 1}));
}

TEST(SerialServer, IsOpenedByTheNameOfItsLink) {
  const ScratchFolder folder;
  CountingBank bank;
  {
    ModbusServer server(bank);
    server.open_pseudo_terminal(folder / "tty");
    const RawClient client((folder / "tty").string());
    client.send(make_serial_frame(1, read_one));
    for (int i = 0; i < 3; ++i) server.poll(0.02);
    EXPECT_EQ(client.receive(7), make_serial_frame(1, one_read));
  }
  EXPECT_EQ(folder.count(), 0U);
}

TEST(ModbusServer, StopsAtOnceAndRefusesImpossibleOptions) {
  CountingBank bank;
  {
    ModbusServer server(bank);
    server.listen("127.0.0.1", 0);
    server.stop();
    EXPECT_TRUE(server.poll(60));
  }
  ServerOptions options;
  options.unit = 248;
  EXPECT_THROW(ModbusServer(bank, options), Error);
  options = {};
  options.most_clients = 0;
  EXPECT_THROW(ModbusServer(bank, options), Error);
}

}  // namespace
}  // namespace gyrator
