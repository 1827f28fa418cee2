#include "gyrator/documents/json_text.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <vector>

#include <fmt/core.h>

namespace gyrator {

namespace {

[[noreturn]] void refuse(const std::string& place, const std::string& message) {
  throw Error(ErrorCode::bad_input, place, message);
}

// "line 3, column 5: RULE", the line and a caret below the column. A column is a character.
std::string describe_position(std::string_view text, std::size_t offset, std::string_view rule) {
  constexpr std::size_t widest = 100;
  offset = std::min(offset, text.size());
  const std::size_t before = text.substr(0, offset).rfind('\n');
  const std::size_t start = before == std::string_view::npos ? 0 : before + 1;
  const auto line_number = std::count(text.begin(), text.begin() + static_cast<long>(start), '\n');
  const auto is_head = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; };

  std::vector<std::string> characters;
  std::size_t column = 0;
  for (std::size_t i = start; i < text.size() && text[i] != '\n'; ++i) {
    if (i <= offset && is_head(text[i])) column = characters.size();
    if (is_head(text[i])) characters.emplace_back();
    const bool is_control = static_cast<unsigned char>(text[i]) < 0x20;
    characters.back() += is_control ? ' ' : text[i];
  }
  if (offset >= text.size() || text[offset] == '\n') column = characters.size();

  // A minified file is one line: show what is around the column.
  const std::size_t from = column > widest / 2 ? column - widest / 2 : 0;
  const std::size_t to = std::min(characters.size(), from + widest);
  std::string shown;
  for (std::size_t i = from; i < to; ++i) shown += characters[i];
  return fmt::format("line {}, column {}: {}\n  {}\n  {}^", line_number + 1, column + 1, rule,
                     shown, std::string(column - from, ' '));
}

// What the parser was reading, and what belongs there.
std::string describe_rule(std::string_view context) {
  if (context == "object key") return "a key in double quotes is expected";
  if (context == "object separator") return "':' is expected after a key";
  if (context == "object") return "',' or '}' is expected";
  if (context == "array") return "',' or ']' is expected";
  return "a value is expected: a number, a text in double quotes, true, false, null, […] or {…}";
}

// The parser's message, "syntax error while parsing object key - unexpected '}'; expected string
// literal", in words that need no knowledge of parsers.
std::string describe_syntax_error(std::string_view what, std::string_view text,
                                  std::size_t offset) {
  constexpr std::string_view lead = "syntax error while parsing ";
  const std::size_t dash = what.find(" - ");
  if (!what.starts_with(lead) || dash == std::string_view::npos) return std::string(what);
  const std::string rule = describe_rule(what.substr(lead.size(), dash - lead.size()));
  std::string_view found = what.substr(dash + 3, what.find(';', dash) - dash - 3);
  constexpr std::string_view literal = " literal";
  if (found.starts_with("unexpected") && found.ends_with(literal))
    found.remove_suffix(literal.size());
  const std::string_view before = trim(text.substr(0, offset));
  if (found == "unexpected end of input") return "the file ends too early: " + rule;
  if (text.substr(offset).starts_with('/') || text.substr(offset).starts_with('#'))
    return "JSON has no comments";
  const bool at_end = found == "unexpected '}'" || found == "unexpected ']'";
  if (at_end && before.ends_with(',')) return "a comma after the last item: JSON allows none there";
  if (found.starts_with("unexpected") || found == "invalid literal") {
    return fmt::format("{}: {}", found == "invalid literal" ? "no JSON" : found, rule);
  }
  return std::string(found);
}

// Where the word that is read at `offset` starts, with its sign, and the word.
struct Word {
  std::size_t start;
  std::string_view text;
};
Word find_word(std::string_view text, std::size_t offset) {
  const auto is_letter = [&](std::size_t i) {
    return (text[i] >= 'a' && text[i] <= 'z') || (text[i] >= 'A' && text[i] <= 'Z');
  };
  std::size_t start = std::min(offset, text.size());
  std::size_t end = start;
  while (start > 0 && is_letter(start - 1)) --start;
  while (end < text.size() && is_letter(end)) ++end;
  if (start > 0 && (text[start - 1] == '-' || text[start - 1] == '+')) --start;
  return {start, text.substr(start, end - start)};
}

bool is_not_finite(std::string_view word) {
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  std::string lower(word);
  for (char& c : lower) c = static_cast<char>(c | ('a' ^ 'A'));
  return lower == "nan" || lower == "inf" || lower == "infinity";
}

// Goes through the text without building anything and refuses what the DOM would take silently
// (a key given twice) or at the cost of the stack (depth). The parser itself does not recurse.
class JsonChecker : public nlohmann::json_sax<nlohmann::json> {
 public:
  JsonChecker(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

  bool null() override { return count_value(); }
  bool boolean(bool) override { return count_value(); }
  bool number_integer(number_integer_t) override { return count_value(); }
  bool number_unsigned(number_unsigned_t) override { return count_value(); }
  bool number_float(number_float_t, const string_t&) override { return count_value(); }
  bool string(string_t&) override { return count_value(); }
  bool binary(binary_t&) override { return count_value(); }
  bool start_object(std::size_t) override { return open(false); }
  bool start_array(std::size_t) override { return open(true); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& key) override {
    Level& level = levels_.back();
    level.key = key;
    if (!level.keys.insert(key).second) {
      refuse(name_ + ": " + write_pointer(), "this key is given twice: keys must differ");
    }
    return true;
  }

  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::detail::exception& error) override {
    // nlohmann: "[json.exception.parse_error.101] parse error at line 1, column 2: WHAT".
    std::string what = error.what();
    if (what.starts_with('[')) what.erase(0, what.find("] ") + 2);
    if (what.starts_with("parse error at")) what.erase(0, what.find(": ") + 2);
    if (error.id == number_overflow) what = "this number is beyond the range of a double (1.8e308)";
    const std::size_t offset = std::min(position > 0 ? position - 1 : 0, text_.size());
    if (const Word word = find_word(text_, offset); is_not_finite(word.text)) {
      const std::string pointer = levels_.empty() ? "/" : write_pointer();
      refuse(name_ + ": " + pointer,
             describe_position(
                 text_, word.start,
                 fmt::format("{} is no JSON number: a finite number is expected", word.text)));
    }
    refuse(name_, describe_position(text_, offset, describe_syntax_error(what, text_, offset)));
  }

 private:
  static constexpr int number_overflow = 406;

  struct Level {
    bool is_array = false;
    std::size_t count = 0;
    std::string key;
    std::set<std::string> keys;
  };

  std::string write_pointer() const {
    nlohmann::json::json_pointer pointer;
    for (const Level& level : levels_) {
      pointer.push_back(level.is_array ? std::to_string(level.count) : level.key);
    }
    return pointer.to_string();
  }

  bool open(bool is_array) {
    if (levels_.size() >= max_json_depth) {
      refuse(
          name_ + ": " + write_pointer(),
          fmt::format("nested deeper than {} levels, which is the most allowed", max_json_depth));
    }
    levels_.push_back({is_array, 0, {}, {}});
    return true;
  }

  bool close() {
    levels_.pop_back();
    return count_value();
  }

  bool count_value() {
    if (!levels_.empty()) ++levels_.back().count;
    return true;
  }

  std::string_view text_;
  std::string name_;
  std::vector<Level> levels_;
};

std::string suggest_file(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::vector<std::string> names;
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator(folder, code)) {
    names.push_back(entry.path().filename().string());
  }
  if (code) return fmt::format("; there is no folder '{}'", folder.string());
  return suggest_name(path.filename().string(), names);
}

}  // namespace

std::string load_json_text(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code code;
  const auto status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) refuse(name, "there is no such file" + suggest_file(path));
  if (std::filesystem::is_directory(status)) refuse(name, "is a folder: a JSON file is expected");

  std::ifstream file(path, std::ios::binary);
  if (!file) refuse(name, fmt::format("cannot be read: {}", std::strerror(errno)));
  // Read and counted rather than asked for its size, which a pipe does not have.
  std::string text;
  std::vector<char> block(std::size_t{1} << 16U);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(file.gcount()));
    if (text.size() > max_json_bytes) {
      refuse(name, fmt::format("is larger than {} MiB, which is the most allowed",
                               max_json_bytes >> 20U));
    }
  }
  if (file.bad()) refuse(name, fmt::format("cannot be read: {}", std::strerror(errno)));
  return text;
}

nlohmann::json load_json_file(const std::filesystem::path& path) {
  return parse_json_text(load_json_text(path), path.string());
}

nlohmann::json parse_json_text(std::string_view text, const std::string& name) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  if (trim(text).empty()) refuse(name, "is empty: a JSON object {…} is expected");
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
    refuse(name, fmt::format("holds a zero byte at offset {} (a binary file, or UTF-16): JSON is "
                             "UTF-8 text",
                             zero));
  }
  if (const auto invalid = find_invalid_utf8(text)) {
    refuse(name, fmt::format("byte 0x{:02x} at offset {} is not UTF-8: JSON is UTF-8 text",
                             static_cast<unsigned char>(text[*invalid]), *invalid));
  }
  JsonChecker checker(text, name);
  nlohmann::json::sax_parse(text, &checker);
  return nlohmann::json::parse(text);
}

}  // namespace gyrator
