#include "gyrator/documents/json_text.hpp"

#include "gyrator/core/error.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

template <class Load>
std::string find_error(Load load) {
  try {
    load();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.what();
  }
  return "no error";
}

std::string parse_error(std::string_view text) {
  return find_error([text] { return parse_json_text(text, "f.json"); });
}

::testing::AssertionResult has(const std::string& message, std::string_view part) {
  if (message.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "'" << part << "' is not in: " << message;
}

TEST(ParseJsonText, gives_the_value) {
  EXPECT_EQ(parse_json_text(R"({"a": [1, 2.5, "x", null, true]})", "f.json"),
            nlohmann::json({{"a", {1, 2.5, "x", nullptr, true}}}));
  EXPECT_EQ(parse_json_text("\xef\xbb\xbf{}", "f.json"), nlohmann::json::object());
}

TEST(ParseJsonText, syntax_error_has_line_column_expectation_and_caret) {
  const std::string message = parse_error("{\n  \"a\": 1,\n  \"b\": }\n");
  EXPECT_TRUE(has(message, "f.json: line 3, column 8: "));
  EXPECT_TRUE(has(message, "unexpected '}'"));
  EXPECT_TRUE(has(message, "\n    \"b\": }\n         ^"));
}

TEST(ParseJsonText, column_counts_characters_and_not_bytes) {
  EXPECT_TRUE(has(parse_error("{\"\u00b5\u03a9\": }"), "line 1, column 8: "));
  EXPECT_TRUE(has(parse_error("\xef\xbb\xbf{\"a\": }"), "line 1, column 7: "));
}

TEST(ParseJsonText, truncated_text_is_shown_at_its_end) {
  const std::string message = parse_error("{\n  \"a\": [1, 2");
  EXPECT_TRUE(has(message, "line 2, column 13: "));
  EXPECT_TRUE(has(message, "the file ends too early"));
  EXPECT_TRUE(has(message, "']' is expected"));
  EXPECT_TRUE(has(parse_error("{\"a\": \"x"), "missing closing quote"));
}

TEST(ParseJsonText, says_what_is_wrong_without_the_jargon_of_parsers) {
  EXPECT_TRUE(has(parse_error("{\"a\": 1,}"), "a comma after the last item"));
  EXPECT_TRUE(has(parse_error("[1,]"), "a comma after the last item"));
  EXPECT_TRUE(has(parse_error("[1 // one\n]"), "JSON has no comments"));
  EXPECT_TRUE(has(parse_error("{\"a\": 1 \"b\": 2}"), "unexpected string: ',' or '}' is expected"));
  EXPECT_TRUE(has(parse_error("{a: 1}"), "a key in double quotes is expected"));
  EXPECT_TRUE(has(parse_error("{\"a\" 1}"), "':' is expected after a key"));
  EXPECT_TRUE(has(parse_error("{\"a\": yes}"), "a value is expected"));
}

TEST(ParseJsonText, not_a_number_and_infinity_are_named_with_their_pointer) {
  EXPECT_TRUE(has(parse_error("{\"a\": [1,\n NaN]}"),
                  "f.json: /a/1: line 2, column 2: NaN is no JSON number"));
  EXPECT_TRUE(has(parse_error("{\"a\": -Infinity}"),
                  "f.json: /a: line 1, column 7: -Infinity is no JSON number"));
}

TEST(ParseJsonText, long_line_is_shown_around_the_column) {
  const std::string message = parse_error("[" + std::string(100000, '1') + " x]");
  EXPECT_LT(message.size(), 500U);
  EXPECT_TRUE(has(message, "column "));
}

TEST(ParseJsonText, text_behind_the_value_is_an_error) {
  EXPECT_TRUE(has(parse_error("{} {}"), "column 4"));
}

TEST(ParseJsonText, empty_binary_and_ill_formed_texts_are_named) {
  EXPECT_TRUE(has(parse_error(""), "is empty"));
  EXPECT_TRUE(has(parse_error(" \n\t"), "is empty"));
  EXPECT_TRUE(has(parse_error(std::string_view("{\0}", 3)), "zero byte at offset 1"));
  EXPECT_TRUE(has(parse_error("{\"a\": \"\xff\"}"), "byte 0xff at offset 7 is not UTF-8"));
}

TEST(ParseJsonText, nesting_may_be_64_deep_and_no_deeper) {
  const auto nest = [](int depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_EQ(parse_error(nest(max_json_depth)), "no error");
  EXPECT_TRUE(has(parse_error(nest(max_json_depth + 1)), "nested deeper than 64 levels"));
  EXPECT_TRUE(has(parse_error(std::string(10000000, '[')), "nested deeper than 64 levels"));
}

TEST(ParseJsonText, key_given_twice_is_refused_at_its_pointer) {
  EXPECT_EQ(parse_error(R"({"a": [0, {"b": 1, "c/d": {}, "c/d": 2}]})"),
            "f.json: /a/1/c~1d: this key is given twice: keys must differ");
  EXPECT_EQ(parse_error(R"({"a": {"a": 1}, "b": {"a": 1}})"), "no error");
}

TEST(ParseJsonText, number_beyond_a_double_is_refused_at_its_place) {
  const std::string message = parse_error("{\n\"a\": 1e999}");
  EXPECT_TRUE(has(message, "line 2, column "));
  EXPECT_TRUE(has(message, "beyond the range of a double"));
  EXPECT_EQ(parse_error("1e308"), "no error");
  EXPECT_TRUE(has(parse_error("NaN"), "line 1, column 1"));
}

class LoadJsonFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("gyrator_json_text_" + std::string(test->name()) + "_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  std::filesystem::path folder_;
};

TEST_F(LoadJsonFile, gives_the_value) {
  EXPECT_EQ(load_json_file(write("a.json", "{\"a\": 1}")), nlohmann::json({{"a", 1}}));
}

TEST_F(LoadJsonFile, missing_file_suggests_its_neighbour) {
  write("device.json", "{}");
  EXPECT_TRUE(has(find_error([&] { load_json_file(folder_ / "devcie.json"); }),
                  "there is no such file; did you mean 'device.json'?"));
  EXPECT_TRUE(
      has(find_error([&] { load_json_file(folder_ / "none" / "a.json"); }), "there is no folder"));
}

TEST_F(LoadJsonFile, folder_and_empty_file_are_named) {
  EXPECT_TRUE(has(find_error([&] { load_json_file(folder_); }), "is a folder"));
  const auto empty = write("empty.json", "");
  EXPECT_EQ(find_error([&] { load_json_file(empty); }),
            empty.string() + ": is empty: a JSON object {…} is expected");
}

TEST_F(LoadJsonFile, file_of_64_mib_is_read_and_a_larger_one_refused) {
  std::string text = "{}" + std::string(max_json_bytes - 2, ' ');
  EXPECT_EQ(load_json_file(write("large.json", text)), nlohmann::json::object());
  text += ' ';
  EXPECT_TRUE(
      has(find_error([&] { load_json_file(write("larger.json", text)); }), "larger than 64 MiB"));
}

}  // namespace
}  // namespace gyrator
