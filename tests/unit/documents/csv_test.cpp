#include "gyrator/documents/csv.hpp"

#include "gyrator/core/error.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
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

TEST(Csv, ReadsBackWhatItWrote) {
  const ScratchFolder folder;
  const std::vector<std::vector<double>> data{{0, 1.0 / 3.0, 1e-300}, {2, -3, 4e7}};
  write_csv(folder / "trace.csv", {"time_s", "a \"b\", c"}, data);
  const CsvColumns read = read_csv(folder / "trace.csv", {"a \"b\", c", "time_s"});
  EXPECT_EQ(read.columns, (std::vector<std::vector<double>>{data[1], data[0]}));
  EXPECT_EQ(read.lines, (std::vector<long>{2, 3, 4}));
}

TEST(Csv, ReadsWhatOtherProgramsWrite) {
  const ScratchFolder folder;
  std::ofstream(folder / "r.csv")
      << "\xEF\xBB\xBFtime_s, note,force\r\n0,x,+1.5\r\n\r\n 0.1 ,\"a,b\",-2e-1\r\n";
  const CsvColumns read = read_csv(folder / "r.csv", {"time_s", "force"});
  EXPECT_EQ(read.columns, (std::vector<std::vector<double>>{{0, 0.1}, {1.5, -0.2}}));
  EXPECT_EQ(read.lines, (std::vector<long>{2, 4}));
}

TEST(Csv, NamesFileLineAndColumnOfWhatItCannotRead) {
  const ScratchFolder folder;
  const std::string path = folder / "r.csv";
  const auto refusal = [&](const std::string& text) -> std::string {
    std::ofstream(path) << text;
    try {
      read_csv(path, {"time_s", "force"});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_TRUE(std::string(error.what()).starts_with(path)) << error.what();
      return std::string(error.what()).substr(path.size());
    }
    return "accepted";
  };
  for (const char* gap :
       {"0,1\n1,\n", "0,1\n1\n", "0,1\n1,nan\n", "0,1\n1,inf\n", "0,1\n1,-\n", "0,1\n1,2x\n"}) {
    const std::string message = refusal(std::string("time_s,force\n") + gap);
    EXPECT_TRUE(message.starts_with(":3: column \"force\": ")) << gap << message;
  }
  EXPECT_NE(refusal("time_s,force\n0,1\n1,inf\n").find("not finite"), std::string::npos);
  EXPECT_NE(refusal("time_s,force\n0,1\n1,nan\n").find("a gap"), std::string::npos);
  EXPECT_TRUE(refusal("time_s,force\n0,1\n1,2,5\n").starts_with(":3: 3 fields"));
  EXPECT_TRUE(refusal("\ntime_s,force,force\n0,1,2\n").starts_with(":2: column \"force\": there"));
  EXPECT_EQ(refusal("time_s,force,x,x\n0,1,2,3\n"), "accepted");  // neither is asked for
  EXPECT_NE(refusal("time_s,forse\n0,1\n").find("'forse' is nearly its name"), std::string::npos);
  EXPECT_NE(refusal("").find("is empty"), std::string::npos);
  EXPECT_NE(refusal("time_s,force\n").find("no row"), std::string::npos);
  EXPECT_TRUE(refusal("time_s,force\n0,\"1\n").starts_with(":2: a quote"));
  EXPECT_THROW(read_csv(folder / "none.csv", {"a"}), Error);
}

}  // namespace
}  // namespace gyrator
