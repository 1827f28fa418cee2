#include "gyrator/documents/column_file.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/output_file.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "support/scratch_folder.hpp"

namespace gyrator {
namespace {

ColumnFile example() {
  ColumnFile file;
  // Longer than the 64 KiB that an attribute may have in a plain object header.
  file.attributes = {
      {"model", std::string(200000, 'x') + "Ω"}, {"seed", std::int64_t{1} << 60}, {"none", ""}};
  file.columns.push_back(
      {"z", {{"unit", "N.m/rad"}}, std::vector<double>{1.0 / 3, NAN, -HUGE_VAL}});
  file.columns.push_back({"a", {{"unit", "1"}}, std::vector<std::int32_t>{0, -1, 2}});
  file.columns.push_back({"m", {}, std::vector<std::string>{"", "two, \"words\"", "µF"}});
  return file;
}

TEST(ColumnFile, reads_back_what_was_written_in_the_same_order) {
  const ScratchFolder folder;
  const std::string path = (folder / "file.h5").string();
  const ColumnFile written = example();
  write_hdf5(path, written);
  const ColumnFile read = read_hdf5(path);
  ASSERT_EQ(read.attributes.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(read.attributes[i], written.attributes[i]);
  ASSERT_EQ(read.columns.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.columns[i].name, written.columns[i].name);
    EXPECT_EQ(read.columns[i].attributes, written.columns[i].attributes);
  }
  const auto& numbers = std::get<std::vector<double>>(read.columns[0].values);
  EXPECT_EQ(numbers[0], 1.0 / 3);
  EXPECT_TRUE(std::isnan(numbers[1]));
  EXPECT_EQ(numbers[2], -HUGE_VAL);
  EXPECT_EQ(read.columns[1].values, written.columns[1].values);
  EXPECT_EQ(read.columns[2].values, written.columns[2].values);
}

TEST(ColumnFile, the_same_columns_give_the_same_bytes) {
  const ScratchFolder folder;
  const auto bytes_of = [&](const ColumnFile& file) {
    const std::string path = (folder / "file.h5").string();
    write_hdf5(path, file);
    return read_text(path);
  };
  const std::string bytes = bytes_of(example());
  EXPECT_EQ(bytes_of(example()), bytes);
  ColumnFile other = example();
  std::get<std::vector<double>>(other.columns[0].values)[0] += 1e-16;
  EXPECT_NE(bytes_of(other), bytes);
}

TEST(ColumnFile, columns_without_rows_are_columns) {
  const ScratchFolder folder;
  const std::string path = (folder / "file.h5").string();
  ColumnFile file;
  file.columns.push_back({"x", {{"unit", "s"}}, std::vector<double>{}});
  write_hdf5(path, file);
  EXPECT_EQ(read_hdf5(path).columns.at(0).size(), 0U);
}

TEST(ColumnFile, what_is_no_such_file_is_refused_by_name) {
  const ScratchFolder folder;
  const std::string path = (folder / "text.h5").string();
  write_text_file(path, "not HDF5");
  for (const std::string& wrong : {path, (folder / "missing.h5").string()}) {
    try {
      read_hdf5(wrong);
      FAIL() << wrong;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_EQ(error.place(), wrong);
    }
  }
}

}  // namespace
}  // namespace gyrator
