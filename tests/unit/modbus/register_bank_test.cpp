#include "gyrator/modbus/register_bank.hpp"

#include "gyrator/modbus/modbus_frame.hpp"

#include <map>
#include <random>

#include <gtest/gtest.h>

#include "support/modbus_bench.hpp"

namespace gyrator {
namespace {

using modbus_tests::CountingBank;

constexpr auto illegal_function = static_cast<std::uint8_t>(ModbusException::illegal_function);
constexpr auto illegal_address = static_cast<std::uint8_t>(ModbusException::illegal_data_address);
constexpr auto illegal_value = static_cast<std::uint8_t>(ModbusException::illegal_data_value);

TEST(Crc16, IsThatOfTheSpecification) {
  // Modbus over serial line 1.02, figure 30: bytes 02 07 give 1241 hexadecimal.
  EXPECT_EQ(compute_crc16(Bytes{0x02, 0x07}), 0x1241);
  const Bytes frame = make_serial_frame(0x02, Bytes{0x07});
  EXPECT_EQ(frame, (Bytes{0x02, 0x07, 0x41, 0x12}));
  EXPECT_TRUE(has_valid_crc(frame));
  for (std::size_t i = 0; i < 8 * frame.size(); ++i) {
    Bytes wrong = frame;
    wrong[i / 8] ^= static_cast<std::uint8_t>(1U << i % 8);
    EXPECT_FALSE(has_valid_crc(wrong));
  }
}

// The examples of the Modbus application protocol 1.1b3, section 6, with this bank's values.
TEST(AnswerRequest, AnswersAsTheSpecificationsExamples) {
  CountingBank bank;
  bank.holdings[107] = 0x022B;
  bank.holdings[109] = 0x0064;
  bank.holdings[4] = 0x12;
  EXPECT_EQ(answer_request(Bytes{0x03, 0x00, 0x6B, 0x00, 0x03}, bank),
            (Bytes{0x03, 0x06, 0x02, 0x2B, 0x00, 0x00, 0x00, 0x64}));
  EXPECT_EQ(answer_request(Bytes{0x05, 0x00, 0xAC, 0xFF, 0x00}, bank),
            (Bytes{0x05, 0x00, 0xAC, 0xFF, 0x00}));
  EXPECT_TRUE(bank.coils[0xAC]);
  EXPECT_EQ(answer_request(Bytes{0x06, 0x00, 0x01, 0x00, 0x03}, bank),
            (Bytes{0x06, 0x00, 0x01, 0x00, 0x03}));
  EXPECT_EQ(bank.holdings[1], 3);
  EXPECT_EQ(answer_request(Bytes{0x0F, 0x00, 0x13, 0x00, 0x0A, 0x02, 0xCD, 0x01}, bank),
            (Bytes{0x0F, 0x00, 0x13, 0x00, 0x0A}));
  const std::vector<bool> coils(bank.coils.begin() + 19, bank.coils.begin() + 29);
  EXPECT_EQ(coils, (std::vector<bool>{1, 0, 1, 1, 0, 0, 1, 1, 1, 0}));
  EXPECT_EQ(answer_request(Bytes{0x01, 0x00, 0x13, 0x00, 0x0A}, bank),
            (Bytes{0x01, 0x02, 0xCD, 0x01}));
  EXPECT_EQ(answer_request(Bytes{0x10, 0x00, 0x01, 0x00, 0x02, 0x04, 0x00, 0x0A, 0x01, 0x02}, bank),
            (Bytes{0x10, 0x00, 0x01, 0x00, 0x02}));
  EXPECT_EQ(bank.holdings[2], 0x0102);
  EXPECT_EQ(answer_request(Bytes{0x16, 0x00, 0x04, 0x00, 0xF2, 0x00, 0x25}, bank),
            (Bytes{0x16, 0x00, 0x04, 0x00, 0xF2, 0x00, 0x25}));
  EXPECT_EQ(bank.holdings[4], 0x17);
  EXPECT_EQ(
      answer_request(Bytes{0x17, 0x00, 0x01, 0x00, 0x02, 0x00, 0x02, 0x00, 0x01, 0x02, 0xAB, 0xCD},
                     bank),
      (Bytes{0x17, 0x04, 0x00, 0x0A, 0xAB, 0xCD}));
  EXPECT_EQ(answer_request(Bytes{0x02, 0x00, 0x00, 0x00, 0x04}, bank), (Bytes{0x02, 0x01, 0x09}));
  EXPECT_EQ(answer_request(Bytes{0x04, 0x00, 0x02, 0x00, 0x01}, bank),
            (Bytes{0x04, 0x02, 0x00, 0x0F}));
}

TEST(AnswerRequest, RefusesWithTheRightException) {
  CountingBank bank;
  const std::vector<std::pair<Bytes, std::uint8_t>> refused{
      {{0x07}, illegal_function},
      {{0x2B, 0x0E, 0x01, 0x00}, illegal_function},
      {{0x03, 0x00, 0x00, 0x00, 0x00}, illegal_value},              // none
      {{0x03, 0x00, 0x00, 0x00, 0x7E}, illegal_value},              // 126
      {{0x01, 0x00, 0x00, 0x07, 0xD1}, illegal_value},              // 2001
      {{0x03, 0xFF, 0xFF, 0x00, 0x02}, illegal_address},            // past the end of the table
      {{0x03, 0x00, 0xC7, 0x00, 0x02}, illegal_address},            // past the end of the bank
      {{0x05, 0x00, 0x00, 0x12, 0x34}, illegal_value},              // neither on nor off
      {{0x10, 0x00, 0x00, 0x00, 0x02, 0x02, 1, 2}, illegal_value},  // two words, one sent
      {{0x0F, 0x00, 0x00, 0x00, 0x09, 0x01, 1}, illegal_value},     // nine bits in a byte
      {{0x03, 0x00, 0x00}, illegal_value},                          // too short
      {{0x03, 0x00, 0x00, 0x00, 0x01, 0x00}, illegal_value},        // too long
      {{0x10, 0x00, 0x00}, illegal_value}};
  for (const auto& [request, exception] : refused)
    EXPECT_EQ(answer_request(request, bank),
              (Bytes{static_cast<std::uint8_t>(request[0] | 0x80U), exception}))
        << format_hex(request);
  EXPECT_EQ(bank.writes, 0);
}

TEST(AnswerRequest, IsSilentToWhatIsNoRequest) {
  CountingBank bank;
  EXPECT_TRUE(answer_request(Bytes{}, bank).empty());
  EXPECT_TRUE(answer_request(Bytes{0x00, 0x01}, bank).empty());
  EXPECT_TRUE(answer_request(Bytes{0x83, 0x02}, bank).empty());
  EXPECT_TRUE(answer_request(Bytes(254, 0x03), bank).empty());
}

/// A request that is right, or nearly.
Bytes draw_request(std::mt19937& random) {
  const auto draw = [&](unsigned below) { return static_cast<unsigned>(random() % below); };
  static const std::vector<std::uint8_t> functions{1, 2, 3, 4, 5, 6, 15, 16, 22, 23};
  Bytes request;
  if (draw(4) == 0) {
    request.resize(draw(300));
    for (auto& byte : request) byte = static_cast<std::uint8_t>(draw(256));
    return request;
  }
  request.push_back(functions[draw(10)]);
  append_word(request, static_cast<std::uint16_t>(draw(250)));
  append_word(request, static_cast<std::uint16_t>(draw(140)));
  if (request[0] == 22 || request[0] == 23)
    append_word(request, static_cast<std::uint16_t>(draw(250)));
  if (request[0] == 23) append_word(request, static_cast<std::uint16_t>(draw(130)));
  if (request[0] == 15 || request[0] == 16 || request[0] == 23) {
    const unsigned count = request[request.size() - 1];
    const unsigned bytes = request[0] == 15 ? (count + 7) / 8 : 2 * count;
    request.push_back(static_cast<std::uint8_t>(bytes));
    for (unsigned i = 0; i < bytes; ++i) request.push_back(static_cast<std::uint8_t>(draw(256)));
  }
  if (draw(4) == 0)
    request[draw(static_cast<unsigned>(request.size()))] ^=
        static_cast<std::uint8_t>(1U << draw(8));
  if (draw(8) == 0) request.resize(draw(static_cast<unsigned>(request.size()) + 1));
  return request;
}

TEST(AnswerRequest, AnswersRandomRequestsWithNothingButWellFormedAnswers) {
  CountingBank bank;
  std::mt19937 random(2026);
  std::map<bool, int> seen;
  constexpr int requests = 100000;
  for (int i = 0; i < requests; ++i) {
    const Bytes request = draw_request(random);
    // A copy without a byte to spare, for the address sanitizer to see reads past its end.
    const std::vector<std::uint8_t> exact(request.begin(), request.end());
    const Bytes answer = answer_request(exact, bank);
    if (answer.empty()) {
      const bool silent =
          request.empty() || request.size() > longest_pdu || request[0] == 0 || request[0] > 127;
      ASSERT_TRUE(silent) << format_hex(request);
      continue;
    }
    ASSERT_LE(answer.size(), longest_pdu);
    ASSERT_EQ(answer[0] & 0x7F, request[0]);
    const auto exception = find_exception(answer);
    ++seen[exception.has_value()];
    if (exception) {
      ASSERT_GE(static_cast<int>(*exception), 1);
      ASSERT_LE(static_cast<int>(*exception), 3);
    } else if (request[0] <= 16) {
      ASSERT_EQ(find_answer_mistake(request, answer), "") << format_hex(request);
    } else if (request[0] == 22) {
      ASSERT_EQ(answer, request);
    } else {
      ASSERT_EQ(answer.size(), 2U + 2U * read_word(request, 3));
    }
  }
  EXPECT_GT(seen[false], requests / 5);
  EXPECT_GT(seen[true], requests / 10);
}

TEST(AnswerMistake, IsFoundInEveryByteThatMatters) {
  CountingBank bank;
  const std::vector<Bytes> requests{make_read_request(RegisterTable::holding, 3, 4),
                                    make_read_request(RegisterTable::coil, 3, 11),
                                    make_register_request(3, 0x1234),
                                    make_coil_request(3, true),
                                    make_registers_request(3, std::vector<std::uint16_t>{1, 2}),
                                    make_coils_request(3, {true, false, true})};
  for (const Bytes& request : requests) {
    const Bytes answer = answer_request(request, bank);
    EXPECT_EQ(find_answer_mistake(request, answer), "");
    const bool read = request[0] <= 4;
    for (std::size_t i = 0; i < (read ? 2 : answer.size()); ++i) {
      Bytes wrong = answer;
      wrong[i] ^= 0x10U;
      EXPECT_NE(find_answer_mistake(request, wrong), "") << format_hex(wrong);
    }
    for (const std::ptrdiff_t less : {1, 2}) {
      const Bytes shorter(answer.begin(), answer.end() - less);
      EXPECT_NE(find_answer_mistake(request, shorter), "");
    }
    Bytes longer = answer;
    longer.push_back(0);
    EXPECT_NE(find_answer_mistake(request, longer), "");
  }
}

}  // namespace
}  // namespace gyrator
