#include "gyrator/amplifiers/device_register.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/random_stream.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

constexpr std::array types{RegisterType::bit, RegisterType::u16, RegisterType::i16,
                           RegisterType::u32, RegisterType::i32, RegisterType::u64,
                           RegisterType::f32, RegisterType::f64};
constexpr std::array orders{WordOrder::abcd, WordOrder::badc, WordOrder::cdab, WordOrder::dcba};

DeviceRegister make_register(RegisterType type, WordOrder order = WordOrder::abcd) {
  DeviceRegister place;
  place.name = "tested";
  place.type = type;
  place.order = order;
  return place;
}

std::string refusal(const DeviceRegister& place, double value) {
  try {
    to_raw(place, value);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.what();
  }
  return "nothing was refused";
}

// The words of a random value, as a device would hold it.
std::vector<std::uint16_t> draw_words(const DeviceRegister& place, RandomStream& random) {
  std::vector<std::uint16_t> words(static_cast<std::size_t>(place.words()));
  for (auto& word : words) word = static_cast<std::uint16_t>(random.uniform() * 65536);
  if (place.type == RegisterType::bit) words[0] &= 1;
  // A whole number of a double: 53 bits.
  if (place.type == RegisterType::u64)
    words = encode_value(decode_pattern(words, place.order) >> 11U, place.type, place.order);
  return words;
}

TEST(DeviceRegister, ReadingAndWritingAreInversesInEveryTypeAndOrder) {
  RandomStream random(7, 0);
  for (const RegisterType type : types) {
    for (const WordOrder order : orders) {
      DeviceRegister place = make_register(type, order);
      for (int i = 0; i < 2000; ++i) {
        const auto words = draw_words(place, random);
        const auto value = to_physical(place, take_raw(place, words));
        if (!value || !std::isfinite(*value)) continue;  // a float that is no number
        EXPECT_EQ(put_raw(place, to_raw(place, *value)), words)
            << name_of(type) << " " << name_of(order) << " " << *value;
      }
    }
  }
}

TEST(DeviceRegister, ScaleOffsetAndUnitAreInvertedOnWrites) {
  RandomStream random(11, 0);
  const std::array<std::array<double, 3>, 5> laws{
      {{0.1, 273.15, 1}, {0.001, 0, 1}, {10, 0, 1e-6}, {-0.5, 12, 1e-3}, {0.000383495197, 0, 1}}};
  for (const RegisterType type :
       {RegisterType::u16, RegisterType::i16, RegisterType::u32, RegisterType::i32}) {
    for (const auto& [scale, offset, factor] : laws) {
      DeviceRegister place = make_register(type, WordOrder::cdab);
      place.scale = scale;
      place.offset = offset;
      place.factor = factor;
      for (int i = 0; i < 500; ++i) {
        const auto words = draw_words(place, random);
        const double value = *to_physical(place, take_raw(place, words));
        EXPECT_EQ(put_raw(place, to_raw(place, value)), words) << value;
        // Anything nearer to it than to its neighbours is the same number.
        if (range_of(place).low < value && value < range_of(place).high) {
          EXPECT_EQ(put_raw(place, to_raw(place, value + 0.49 * scale * factor)), words) << value;
        }
      }
    }
  }
}

TEST(DeviceRegister, AWriteIsRoundedToTheStep) {
  DeviceRegister place = make_register(RegisterType::f32);
  place.low = 2;
  place.high = 129.5;
  place.step = 0.5;
  EXPECT_EQ(std::get<double>(to_raw(place, 2.3)), 2.5);
  EXPECT_EQ(std::get<double>(to_raw(place, 2.2)), 2);
  EXPECT_EQ(std::get<double>(to_raw(place, 129.5)), 129.5);
  EXPECT_EQ(find_nearest_value(place, 1000), 129.5);
  place.low = 1;
  place.step = 3;  // 1, 4, … 127, 130: the last is beyond the limit
  EXPECT_EQ(find_nearest_value(place, 1000), 127);
}

TEST(DeviceRegister, AStepInFloatsIsReadBackAsItself) {
  DeviceRegister place = make_register(RegisterType::f32);
  place.low = 0;
  place.high = 20;
  place.step = 0.01;
  for (int i = 0; i <= 2000; ++i) {
    const RawValue raw = to_raw(place, 0.01 * i);
    EXPECT_EQ(to_raw(place, *to_physical(place, raw)), raw) << i;
  }
}

TEST(DeviceRegister, BeyondLimitsAndTypesIsRefused) {
  DeviceRegister place = make_register(RegisterType::u16);
  place.unit = "mA";
  place.factor = 1e-3;
  place.low = 0.1;
  place.high = 5;
  EXPECT_EQ(refusal(place, 5.001), "tested: 5001 mA: must be at most 5000 mA");
  EXPECT_EQ(refusal(place, 0.0999), "tested: 99.9 mA: must be at least 100 mA");
  EXPECT_NE(refusal(place, NAN).find("finite"), std::string::npos);
  EXPECT_EQ(std::get<std::uint64_t>(to_raw(place, 5)), 5000U);
  place.low.reset();
  place.high.reset();
  EXPECT_NE(refusal(place, 66).find("at most 65535 mA"), std::string::npos);
  EXPECT_NE(refusal(make_register(RegisterType::f32), 1e39).find("at most"), std::string::npos);
}

TEST(DeviceRegister, ALimitThatWasReadBackIsAllowed) {
  DeviceRegister place = make_register(RegisterType::f32);
  place.high = 0.1;  // its float lies above it
  const RawValue raw = to_raw(place, 0.1);
  EXPECT_GT(*to_physical(place, raw), 0.1);
  EXPECT_EQ(to_raw(place, *to_physical(place, raw)), raw);
}

TEST(DeviceRegister, ASentinelIsNoValue) {
  DeviceRegister place = make_register(RegisterType::i16);
  place.scale = 0.1;
  place.not_implemented = std::int64_t{-32768};
  EXPECT_FALSE(to_physical(place, std::int64_t{-32768}));
  EXPECT_TRUE(to_physical(place, std::int64_t{-32767}));
  EXPECT_NE(refusal(place, -3276.8).find("not implemented"), std::string::npos);
  EXPECT_FALSE(to_physical(make_register(RegisterType::f32),
                           RawValue(std::numeric_limits<double>::quiet_NaN())));
}

TEST(DeviceRegister, OverlapsTheAddressesOfItsTableThatHoldAWordOfIt) {
  DeviceRegister place;
  place.table = RegisterTable::holding;
  place.type = RegisterType::f32;  // 20 and 21
  place.address = 20;
  EXPECT_FALSE(overlaps(place, RegisterTable::holding, 10, 10));
  EXPECT_TRUE(overlaps(place, RegisterTable::holding, 10, 11));
  EXPECT_TRUE(overlaps(place, RegisterTable::holding, 21, 1));
  EXPECT_FALSE(overlaps(place, RegisterTable::holding, 22, 5));
  EXPECT_FALSE(overlaps(place, RegisterTable::input, 20, 2));
}

TEST(DeviceRegister, ABitFieldLeavesTheOtherBits) {
  for (const RegisterType type : {RegisterType::u16, RegisterType::u32}) {
    for (const WordOrder order : orders) {
      DeviceRegister place = make_register(type, order);
      place.bits = BitField{3, 4};
      const std::uint64_t all = type == RegisterType::u16 ? 0xffffU : 0xffffffffU;
      const auto words = encode_value(all, type, order);
      const auto changed = put_raw(place, to_raw(place, 5), words);
      EXPECT_EQ(std::get<std::uint64_t>(decode_value(changed, type, order)),
                (all & ~0x78ULL) | (5U << 3U));
      EXPECT_EQ(to_physical(place, take_raw(place, changed)), 5);
      EXPECT_NE(refusal(place, 16).find("at most 15"), std::string::npos);
    }
  }
}

TEST(DeviceRegister, OnlyCodesCanBeWritten) {
  DeviceRegister place = make_register(RegisterType::u16);
  place.codes = {{"current", 1}, {"voltage", 4}};
  EXPECT_EQ(std::get<std::uint64_t>(to_raw(place, 4)), 4U);
  EXPECT_EQ(refusal(place, 2), "tested: 2: no code of it: allowed: 1 (current), 4 (voltage)");
  EXPECT_EQ(parse_register_value(place, "voltage"), 4);
  EXPECT_EQ(describe_value(place, 1), "current");
  EXPECT_THROW(parse_register_value(place, "voltaje"), Error);
}

TEST(DeviceRegister, ValuesOfPeopleAreInItsUnitOrInTheirOwn) {
  DeviceRegister place = make_register(RegisterType::u16);
  place.unit = "mA";
  place.factor = 1e-3;
  place.dimension = dimension::current.dimension;
  EXPECT_DOUBLE_EQ(parse_register_value(place, "500"), 0.5);
  EXPECT_DOUBLE_EQ(parse_register_value(place, "0.5A"), 0.5);
  EXPECT_THROW(parse_register_value(place, "0.5 V"), Error);
  EXPECT_EQ(parse_register_value(make_register(RegisterType::bit), "on"), 1);
}

}  // namespace
}  // namespace gyrator
