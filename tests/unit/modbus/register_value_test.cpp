#include "gyrator/modbus/register_value.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/random_stream.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <modbus/modbus.h>
#include <random>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using Words = std::vector<std::uint16_t>;

constexpr std::array all_orders{WordOrder::abcd, WordOrder::badc, WordOrder::cdab, WordOrder::dcba};
constexpr std::array all_types{RegisterType::bit, RegisterType::u16, RegisterType::i16,
                               RegisterType::u32, RegisterType::i32, RegisterType::u64,
                               RegisterType::f32, RegisterType::f64};

/// Bits drawn at random, and those that go wrong first: ends of ranges, zeros, infinities,
/// not-a-numbers quiet and signalling.
std::vector<std::uint64_t> patterns_of(RegisterType type) {
  std::vector<std::uint64_t> patterns{
      0, 1, ~0ULL, 1ULL << 63U, 0x7FFFFFFFFFFFFFFFULL, 0x8000000080008000ULL};
  if (type == RegisterType::f32)
    for (const std::uint64_t pattern : {0x7F800000, 0x7F800001, 0x7FBFFFFF, 0x7FC00000, 0x7FC12345,
                                        0x00000001, 0x007FFFFF, 0x00800000, 0x7F7FFFFF})
      for (const std::uint64_t sign : {0ULL, 0x80000000ULL}) patterns.push_back(pattern | sign);
  if (type == RegisterType::f64)
    for (const std::uint64_t pattern :
         {0x7FF0000000000000ULL, 0x7FF0000000000001ULL, 0x7FF8000000000000ULL,
          0x7FF8000000ABCDEFULL, 0x000FFFFFFFFFFFFFULL})
      for (const std::uint64_t sign : {0ULL, 1ULL << 63U}) patterns.push_back(pattern | sign);
  std::mt19937_64 random(7);
  for (int i = 0; i < 20000; ++i) patterns.push_back(random());
  const int bits = 16 * words_of(type);
  for (std::uint64_t& pattern : patterns)
    pattern &= type == RegisterType::bit ? 1 : bits == 64 ? ~0ULL : (1ULL << bits) - 1;
  return patterns;
}

TEST(RegisterValue, EveryPatternOfEveryTypeComesBackInEveryOrder) {
  for (const RegisterType type : all_types)
    for (const WordOrder order : all_orders)
      for (const std::uint64_t pattern : patterns_of(type)) {
        // A coil's bit has no bytes to swap.
        const WordOrder used = type == RegisterType::bit ? WordOrder::abcd : order;
        const Words words = encode_pattern(pattern, words_of(type), used);
        const RawValue value = decode_value(words, type, order);
        ASSERT_EQ(encode_value(value, type, order), words)
            << name_of(type) << ' ' << name_of(order) << " 0x" << std::hex << pattern;
        ASSERT_EQ(decode_pattern(words, used), pattern);
      }
}

TEST(RegisterValue, DecodesTheNumberThatTheBitsMean) {
  std::mt19937_64 random(11);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random();
    const auto low = static_cast<std::uint32_t>(bits);
    const auto decoded = [](std::uint64_t pattern, RegisterType type) {
      return decode_value(encode_pattern(pattern, words_of(type), WordOrder::abcd), type,
                          WordOrder::abcd);
    };
    EXPECT_EQ(std::get<std::int64_t>(decoded(bits & 0xFFFF, RegisterType::i16)),
              static_cast<std::int16_t>(bits));
    EXPECT_EQ(std::get<std::int64_t>(decoded(low, RegisterType::i32)),
              static_cast<std::int32_t>(low));
    EXPECT_EQ(std::get<std::uint64_t>(decoded(low, RegisterType::u32)), low);
    EXPECT_EQ(std::get<std::uint64_t>(decoded(bits, RegisterType::u64)), bits);
    const auto single = std::bit_cast<float>(low);
    const double wide = std::get<double>(decoded(low, RegisterType::f32));
    if (std::isnan(single))
      EXPECT_TRUE(std::isnan(wide));
    else
      EXPECT_EQ(wide, static_cast<double>(single));
  }
}

TEST(RegisterValue, BytesStandAsTheOrderIsCalled) {
  const std::uint64_t abcd = 0x0A0B0C0D;
  EXPECT_EQ(encode_pattern(abcd, 2, WordOrder::abcd), (Words{0x0A0B, 0x0C0D}));
  EXPECT_EQ(encode_pattern(abcd, 2, WordOrder::badc), (Words{0x0B0A, 0x0D0C}));
  EXPECT_EQ(encode_pattern(abcd, 2, WordOrder::cdab), (Words{0x0C0D, 0x0A0B}));
  EXPECT_EQ(encode_pattern(abcd, 2, WordOrder::dcba), (Words{0x0D0C, 0x0B0A}));
  const std::uint64_t eight = 0x0102030405060708;
  EXPECT_EQ(encode_pattern(eight, 4, WordOrder::cdab), (Words{0x0708, 0x0506, 0x0304, 0x0102}));
  EXPECT_EQ(encode_pattern(eight, 4, WordOrder::badc), (Words{0x0201, 0x0403, 0x0605, 0x0807}));
  EXPECT_EQ(encode_pattern(eight, 4, WordOrder::dcba), (Words{0x0807, 0x0605, 0x0403, 0x0201}));
  EXPECT_EQ(encode_pattern(0x0A0B, 1, WordOrder::cdab), (Words{0x0A0B}));
  EXPECT_EQ(encode_pattern(0x0A0B, 1, WordOrder::dcba), (Words{0x0B0A}));
}

// Its setters of 3.1.6 put the bytes otherwise than its getters take them, so only these compare.
TEST(RegisterValue, FloatsStandWhereLibmodbusReadsThem) {
  const std::array<float (*)(const std::uint16_t*), 4> getters{
      ::modbus_get_float_abcd, ::modbus_get_float_badc, ::modbus_get_float_cdab,
      ::modbus_get_float_dcba};
  RandomStream random(3, 0);
  for (int i = 0; i < 1000; ++i) {
    const auto number = static_cast<float>(random.normal() * std::pow(10, 30 * random.uniform()));
    for (std::size_t order = 0; order < all_orders.size(); ++order) {
      const Words words = encode_value(double{number}, RegisterType::f32, all_orders.at(order));
      ASSERT_EQ(getters.at(order)(words.data()), number) << name_of(all_orders.at(order));
    }
  }
}

TEST(RegisterValue, TakesAnyKindOfNumberThatTheTypeHas) {
  const auto words = [](const RawValue& value, RegisterType type) {
    return encode_value(value, type, WordOrder::abcd);
  };
  EXPECT_EQ(words(5.0, RegisterType::u16), (Words{5}));
  EXPECT_EQ(words(-5.0, RegisterType::i16), (Words{0xFFFB}));
  EXPECT_EQ(words(std::int64_t{5}, RegisterType::u16), (Words{5}));
  EXPECT_EQ(words(std::uint64_t{1} << 31U, RegisterType::f32), (Words{0x4F00, 0}));
  EXPECT_EQ(words(0x1p63, RegisterType::u64), (Words{0x8000, 0, 0, 0}));
}

TEST(RegisterValue, RefusesWhatTheTypeHasNot) {
  const std::vector<std::pair<RawValue, RegisterType>> wrong{
      {std::uint64_t{2}, RegisterType::bit},
      {std::uint64_t{65536}, RegisterType::u16},
      {std::int64_t{-1}, RegisterType::u16},
      {std::int64_t{32768}, RegisterType::i16},
      {std::int64_t{-32769}, RegisterType::i16},
      {std::uint64_t{1} << 32U, RegisterType::u32},
      {std::int64_t{1} << 31U, RegisterType::i32},
      {std::int64_t{-1}, RegisterType::u64},
      {0x1p64, RegisterType::u64},
      {0.5, RegisterType::i32},
      {std::nan(""), RegisterType::i32},
      {1e39, RegisterType::f32},
      {-1.0, RegisterType::u64},
      {65536.0, RegisterType::u16}};
  for (const auto& [value, type] : wrong) {
    try {
      encode_value(value, type, WordOrder::abcd);
      ADD_FAILURE() << name_of(type) << " took " << to_double(value);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
    }
  }
  EXPECT_THROW(decode_value(Words{1}, RegisterType::f32, WordOrder::abcd), Error);
}

TEST(RegisterValue, AddressesAreSaidAsManualsPrintThem) {
  EXPECT_EQ(describe_address(RegisterTable::holding, 16), "holding 0x0010 (40017)");
  EXPECT_EQ(describe_address(RegisterTable::coil, 0), "coil 0x0000 (00001)");
  EXPECT_EQ(describe_address(RegisterTable::discrete, 9), "discrete 0x0009 (10010)");
  EXPECT_EQ(describe_address(RegisterTable::input, 9998), "input 0x270E (39999)");
  EXPECT_EQ(describe_address(RegisterTable::input, 9999), "input 0x270F (310000)");
  EXPECT_EQ(describe_address(RegisterTable::holding, 65535), "holding 0xFFFF (465536)");
}

TEST(RegisterValue, NamesAreFoundAgain) {
  for (const RegisterType type : all_types) EXPECT_EQ(find_register_type(name_of(type)), type);
  for (const WordOrder order : all_orders) EXPECT_EQ(find_word_order(name_of(order)), order);
  EXPECT_EQ(find_word_order("cdab"), WordOrder::cdab);
  EXPECT_EQ(find_register_table("discrete"), RegisterTable::discrete);
  EXPECT_FALSE(find_register_type("u8"));
  EXPECT_FALSE(find_word_order("ACBD"));
}

}  // namespace
}  // namespace gyrator
