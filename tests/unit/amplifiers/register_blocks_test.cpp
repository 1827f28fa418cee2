#include "gyrator/amplifiers/register_blocks.hpp"

#include <gtest/gtest.h>

namespace gyrator {
namespace {

DeviceRegister at(int address, RegisterType type = RegisterType::u16,
                  RegisterTable table = RegisterTable::holding) {
  DeviceRegister place;
  place.address = address;
  place.type = type;
  place.table = table;
  return place;
}

TEST(RegisterBlocks, NeighboursAreReadTogetherAcrossSmallHoles) {
  const DeviceRegister a = at(10, RegisterType::f32), b = at(12), c = at(17), d = at(30);
  const auto blocks = plan_blocks({&d, &c, &a, &b}, 125, 4);
  ASSERT_EQ(blocks.size(), 2U);
  EXPECT_EQ(blocks[0].address, 10);
  EXPECT_EQ(blocks[0].count, 8);
  EXPECT_EQ(blocks[0].places, (std::vector<const DeviceRegister*>{&a, &b, &c}));
  EXPECT_EQ(blocks[1].address, 30);
}

TEST(RegisterBlocks, ABlockIsNoLongerThanTheDeviceAllows) {
  const DeviceRegister a = at(0), b = at(9), c = at(10);
  EXPECT_EQ(plan_blocks({&a, &b, &c}, 10, 100).size(), 2U);
  EXPECT_EQ(plan_blocks({&a, &b, &c}, 11, 100).size(), 1U);
}

TEST(RegisterBlocks, TablesAreApartAndBitFieldsOfAWordTogether) {
  const DeviceRegister a = at(0), b = at(0), c = at(1, RegisterType::bit, RegisterTable::coil);
  const auto blocks = plan_blocks({&a, &c, &b}, 125, 8);
  ASSERT_EQ(blocks.size(), 2U);
  EXPECT_EQ(blocks[0].table, RegisterTable::coil);
  EXPECT_EQ(blocks[1].places.size(), 2U);
  EXPECT_EQ(blocks[1].count, 1);
}

}  // namespace
}  // namespace gyrator
