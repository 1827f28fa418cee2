#include "gyrator/robustness/box_model.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

TEST(BoxModel, IsNotBoundedByWhatIsNotANumber) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(as_remainder(nan), std::numeric_limits<double>::infinity());
  EXPECT_EQ(as_remainder(-1e-18), 0);
  EXPECT_EQ(as_remainder(2), 2);
  BoxModel model = constant_box(1);
  model.remainder = as_remainder(nan);
  EXPECT_FALSE(model.lowest_real() > 0) << "nothing is proved by it";
}

}  // namespace
}  // namespace gyrator
