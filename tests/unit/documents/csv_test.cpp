#include "gyrator/documents/csv.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

TEST(Csv, HasOneHeaderLineAndOneRowPerIndex) {
  const ScratchFolder folder;
  write_csv(folder / "trace.csv", {"time_s", "position"}, {{0, 0.5, 1}, {2, -3, 4}});
  EXPECT_EQ(read_text(folder / "trace.csv"), "time_s,position\n0,2\n0.5,-3\n1,4\n");
  EXPECT_EQ(folder.count(), 1U);
}

TEST(Csv, NumbersReadBackToTheSameBits) {
  const ScratchFolder folder;
  const std::vector<double> values = {0.1,
                                      1.0 / 3.0,
                                      -1e-300,
                                      std::numeric_limits<double>::denorm_min(),
                                      std::numeric_limits<double>::max(),
                                      std::nextafter(1.0, 2.0)};
  write_csv(folder / "values.csv", {"value"}, {values});
  const auto text = read_text(folder / "values.csv");
  const char* at = text.c_str() + text.find('\n') + 1;
  for (const double value : values) {
    char* end = nullptr;
    EXPECT_EQ(std::strtod(at, &end), value);
    ASSERT_EQ(*end, '\n');
    at = end + 1;
  }
}

TEST(Csv, WritesWhatIsNoNumberWithoutSignOfNan) {
  const ScratchFolder folder;
  write_csv(folder / "odd.csv", {"value"}, {{-NAN, INFINITY, -INFINITY}});
  EXPECT_EQ(read_text(folder / "odd.csv"), "value\nnan\ninf\n-inf\n");
}

TEST(Csv, QuotesNamesWithCommasQuotesAndLineBreaks) {
  const ScratchFolder folder;
  write_csv(folder / "names.csv", {"plain", "a,b", "say \"x\"", "two\nlines"},
            {{1}, {2}, {3}, {4}});
  EXPECT_EQ(read_text(folder / "names.csv"),
            "plain,\"a,b\",\"say \"\"x\"\"\",\"two\nlines\"\n1,2,3,4\n");
}

TEST(Csv, RefusesColumnsOfDifferentLengthsAndLeavesNoFile) {
  const ScratchFolder folder;
  EXPECT_THROW(write_csv(folder / "bad.csv", {"a", "b"}, {{1, 2}, {3}}), Error);
  EXPECT_THROW(write_csv(folder / "bad.csv", {"a"}, {{1}, {2}}), Error);
  EXPECT_EQ(folder.count(), 0U);
}

}  // namespace
}  // namespace gyrator
