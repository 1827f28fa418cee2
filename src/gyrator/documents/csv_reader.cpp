#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string_view>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

// The fields of a line; false where a quote is left open.
bool split_fields(std::string_view line, std::vector<std::string>& fields) {
  fields.assign(1, {});
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return !quoted;
}

// Place of a field: "push.csv:12: column "force"".
std::string place_of(const std::string& path, long line, const std::string& column) {
  return fmt::format("{}:{}: column \"{}\"", path, line, column);
}

double parse_field(std::string_view text, const std::string& place) {
  text = trim(text);
  if (text.empty()) throw Error(ErrorCode::bad_input, place, "no number: a gap");
  if (text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size()) {
    throw Error(ErrorCode::bad_input, place,
                fmt::format("'{}': a number is expected, such as 0.25 or 1e-3", text));
  }
  if (!std::isfinite(value)) {
    throw Error(ErrorCode::bad_input, place,
                fmt::format("'{}': {}; every row needs a finite number", text,
                            std::isnan(value) ? "a gap" : "not finite"));
  }
  return value;
}

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path), stream_(path) {
    std::error_code ignored;
    if (!stream_ || std::filesystem::is_directory(path, ignored))
      throw Error(ErrorCode::bad_input, path, "cannot be read: no such file, or no permission");
  }

  // The next line that is not blank, as fields.
  bool next() {
    std::string line;
    while (std::getline(stream_, line)) {
      ++line_;
      std::string_view text = line;
      if (line_ == 1 && text.starts_with(byte_order_mark))
        text.remove_prefix(byte_order_mark.size());
      if (trim(text).empty()) continue;
      if (text.ends_with('\r')) text.remove_suffix(1);
      if (!split_fields(text, fields_))
        throw Error(ErrorCode::bad_input, fmt::format("{}:{}", path_, line_),
                    "a quote is left open");
      return true;
    }
    return false;
  }

  const std::vector<std::string>& fields() const { return fields_; }
  long line() const { return line_; }

 private:
  const std::string& path_;
  std::ifstream stream_;
  std::vector<std::string> fields_;
  long line_ = 0;
};

}  // namespace

CsvColumns read_csv(const std::string& path, const std::vector<std::string>& names) {
  Reader reader(path);
  if (!reader.next())
    throw Error(ErrorCode::bad_input, path, "is empty: a line with the columns' names is expected");
  std::vector<std::string> known = reader.fields();
  for (std::string& name : known) name = std::string(trim(name));
  std::vector<std::size_t> at;
  for (const std::string& name : names) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end()) {
      const auto nearest = find_nearest_name(name, known);
      const std::string near = nearest ? fmt::format("; '{}' is nearly its name", *nearest) : "";
      throw Error(ErrorCode::bad_input, fmt::format("{}:{}", path, reader.line()),
                  fmt::format("no column '{}': there are: {}; needed: {}{}", name, join(known),
                              join(names), near));
    }
    if (std::find(found + 1, known.end(), name) != known.end()) {
      throw Error(ErrorCode::bad_input, place_of(path, reader.line(), name),
                  "there are two of this name: it is not clear which is meant");
    }
    at.push_back(static_cast<std::size_t>(found - known.begin()));
  }
  CsvColumns data;
  data.columns.resize(names.size());
  while (reader.next()) {
    if (const std::size_t n = reader.fields().size(); n > known.size()) {
      throw Error(ErrorCode::bad_input, fmt::format("{}:{}", path, reader.line()),
                  fmt::format("{} fields, but the header has {}: is a decimal comma in it?", n,
                              known.size()));
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      const bool there = at[i] < reader.fields().size();
      data.columns[i].push_back(parse_field(there ? reader.fields()[at[i]] : std::string(),
                                            place_of(path, reader.line(), names[i])));
    }
    data.lines.push_back(reader.line());
  }
  if (data.lines.empty()) throw Error(ErrorCode::bad_input, path, "has no row below its header");
  return data;
}

}  // namespace gyrator
