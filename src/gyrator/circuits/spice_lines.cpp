#include "gyrator/circuits/spice_lines.hpp"

#include "gyrator/circuits/spice_expression.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>

#include <fmt/core.h>

namespace gyrator {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

bool is_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

[[noreturn]] void refuse(const std::string& place, std::string message) {
  throw Error(ErrorCode::bad_input, place, std::move(message));
}

void append_utf8(std::string& text, std::uint32_t code) {
  if (code == 0x3BC) code = 0xB5;
  const auto tail = [&](int shift) {
    text += static_cast<char>(0x80U | ((code >> shift) & 0x3FU));
  };
  if (code < 0x80) {
    text += static_cast<char>(code);
  } else if (code < 0x800) {
    text += static_cast<char>(0xC0U | (code >> 6U));
    tail(0);
  } else if (code < 0x10000) {
    text += static_cast<char>(0xE0U | (code >> 12U));
    tail(6), tail(0);
  } else {
    text += static_cast<char>(0xF0U | (code >> 18U));
    tail(12), tail(6), tail(0);
  }
}

std::string decode_utf16(std::string_view bytes, bool big_endian) {
  std::string text;
  const auto unit = [&](std::size_t i) -> std::uint32_t {
    const std::uint32_t first = static_cast<unsigned char>(bytes[i]);
    const std::uint32_t second = static_cast<unsigned char>(bytes[i + 1]);
    return big_endian ? first << 8U | second : second << 8U | first;
  };
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    std::uint32_t code = unit(i);
    const bool leads = code >= 0xD800 && code < 0xDC00 && i + 3 < bytes.size();
    if (leads && unit(i + 2) >= 0xDC00 && unit(i + 2) < 0xE000) {
      code = 0x10000 + ((code - 0xD800) << 10U) + (unit(i + 2) - 0xDC00);
      i += 2;
    } else if (code >= 0xD800 && code < 0xE000) {
      code = 0xFFFD;  // half of a pair
    }
    append_utf8(text, code);
  }
  return text;
}

std::string decode_bytes(std::string_view bytes) {
  if (bytes.substr(0, 2) == "\xFF\xFE") return decode_utf16(bytes.substr(2), false);
  if (bytes.substr(0, 2) == "\xFE\xFF") return decode_utf16(bytes.substr(2), true);
  // A netlist begins with an ASCII character, whose second byte is zero in UTF-16.
  if (bytes.size() >= 2 && bytes[0] != '\0' && bytes[1] == '\0') return decode_utf16(bytes, false);
  if (bytes.substr(0, 3) == "\xEF\xBB\xBF") bytes.remove_prefix(3);
  std::string text;
  if (find_invalid_utf8(bytes)) {
    for (const char c : bytes) append_utf8(text, static_cast<unsigned char>(c));
    return text;
  }
  text = bytes;
  for (auto at = text.find("\u03BC"); at != std::string::npos; at = text.find("\u03BC", at)) {
    text.replace(at, 2, "\u00B5");
  }
  return text;
}

// Cuts a line's comment off. A '$' counts only between blanks: node names may hold one.
std::string_view without_comment(std::string_view line) {
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (quoted) continue;
    if (line[i] == ';') return line.substr(0, i);
    const bool begins = i == 0 || is_blank(line[i - 1]);
    const bool stands_alone = i + 1 == line.size() || is_blank(line[i + 1]);
    if (line[i] == '$' && begins && stands_alone) return line.substr(0, i);
  }
  return line;
}

// "R1 a b 10k" as a first line: two nodes and a value, or a subcircuit's name behind an X.
bool reads_as_element(std::string_view line) {
  std::vector<std::string_view> words;
  while (!(line = trim(line)).empty()) {
    words.push_back(line.substr(0, line.find_first_of(" \t")));
    line.remove_prefix(words.back().size());
  }
  if (words.size() < 4 || words[0].size() > 8) return false;
  const auto number = find_spice_number(words[3]);
  const bool value = (number && number->length == words[3].size()) || words[3][0] == '{';
  return value && std::string_view("rclviRCLVI").find(words[0][0]) != std::string_view::npos;
}

// Where the value that starts at `at` ends: a brace or quote is kept whole.
std::size_t find_end_of_group(const SpiceLine& line, std::size_t at) {
  const std::string& text = line.text;
  const char open = text[at];
  if (open != '{') {
    const auto end = text.find(open, at + 1);
    if (end != std::string::npos) return end + 1;
    refuse(line.place, fmt::format("'{}': a quote {} has no end", text, open));
  }
  int depth = 0;
  for (std::size_t i = at; i < text.size(); ++i) {
    if (text[i] == '{') ++depth;
    if (text[i] == '}' && --depth == 0) return i + 1;
  }
  refuse(line.place, fmt::format("'{}': a brace {{ has no end", text));
}

// The words of a statement, with every '=' a word of its own.
std::vector<std::string> split_words(const SpiceLine& line) {
  const std::string& text = line.text;
  std::vector<std::string> words;
  std::string word;
  int depth = 0;
  const auto finish_word = [&] {
    if (!word.empty()) words.push_back(std::move(word));
    word.clear();
    depth = 0;
  };
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '{' || ((c == '\'' || c == '"') && word.empty())) {
      const std::size_t end = find_end_of_group(line, i);
      word += text.substr(i, end - i);
      i = end;
      continue;
    }
    ++i;
    if (is_blank(c) || (c == ',' && depth == 0)) {
      finish_word();
    } else if (c == '=') {
      finish_word();
      words.emplace_back("=");
    } else if (c == '(') {
      if (word.empty()) continue;
      ++depth;
      word += c;
    } else if (c == ')') {
      if (depth == 0) {
        finish_word();
        continue;
      }
      --depth;
      word += c;
    } else {
      word += c;
    }
  }
  finish_word();
  return words;
}

}  // namespace

std::string lower_spice(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::string decode_spice_text(std::string_view bytes, const std::string& file) {
  const std::string text = decode_bytes(bytes);
  if (text.find('\0') != std::string::npos) {
    refuse(file, "the file holds NUL characters: a SPICE netlist is text");
  }
  std::string lines;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\r') {
      lines += '\n';
      if (i + 1 < text.size() && text[i + 1] == '\n') ++i;
    } else {
      lines += text[i];
    }
  }
  return lines;
}

std::vector<SpiceLine> split_spice_lines(std::string_view text, const std::string& file,
                                         SpiceFirstLine first) {
  std::vector<SpiceLine> lines;
  int number = 0;
  while (!text.empty()) {
    const auto end = text.find('\n');
    std::string_view line = trim(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    const std::string place = fmt::format("{}:{}", file, number);
    if (number == 1 && first == SpiceFirstLine::title && !line.empty() && line[0] != '.' &&
        line[0] != '*') {
      if (reads_as_element(line)) {
        refuse(place, fmt::format("'{}': the first line of a deck is its title and would be lost: "
                                  "put a title or a line '*' before it",
                                  line));
      }
      continue;
    }
    if (line.empty() || line[0] == '*') continue;
    line = trim(without_comment(line));
    if (line.empty()) continue;
    if (line[0] != '+') {
      lines.push_back({place, std::string(line)});
    } else if (lines.empty()) {
      refuse(place, fmt::format("'{}': '+' continues a line, and there is none before", line));
    } else {
      lines.back().text.append(" ").append(trim(line.substr(1)));
    }
  }
  return lines;
}

SpiceCard parse_spice_card(const SpiceLine& line) {
  SpiceCard card{line.place, line.text, {}, {}};
  const std::vector<std::string> words = split_words(line);
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "=" || (i + 1 < words.size() && words[i + 1] == "=")) {
      if (words[i] == "=" || i + 2 >= words.size() || words[i + 2] == "=") {
        refuse(line.place,
               fmt::format("'{}': '=' needs a name before and a value behind it", line.text));
      }
      card.assignments.push_back({lower_spice(words[i]), words[i + 2]});
      i += 2;
    } else if (lower_spice(words[i]) != "params:") {
      card.words.push_back(words[i]);
    }
  }
  return card;
}

std::vector<SpiceAssignment> parse_spice_parameters(const SpiceLine& line) {
  // Every '=' that assigns, with the name before it; == <= >= != compare.
  struct Start {
    std::size_t name, equals;
  };
  const std::string& text = line.text;
  std::vector<Start> starts;
  const std::size_t body = std::min(text.find_first_of(" \t"), text.size());
  for (std::size_t i = body; i < text.size(); ++i) {
    if (text[i] == '{' || text[i] == '\'') {
      i = find_end_of_group(line, i) - 1;
      continue;
    }
    if (text[i] != '=') continue;
    const bool compares = i + 1 < text.size() && text[i + 1] == '=';
    if (compares) ++i;
    if (compares || std::string_view("<>!").find(text[i - 1]) != std::string_view::npos) continue;
    std::size_t end = i;
    while (end > body && is_blank(text[end - 1])) --end;
    std::size_t name = end;
    while (name > body && is_name(text[name - 1])) --name;
    if (name == end) refuse(line.place, fmt::format("'{}': '=' needs a name before it", text));
    starts.push_back({name, i});
  }
  if (starts.empty() || !trim(text.substr(body, starts[0].name - body)).empty()) {
    refuse(line.place, fmt::format("'{}': a parameter is given as name=value", text));
  }
  std::vector<SpiceAssignment> parameters;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const std::size_t end = k + 1 < starts.size() ? starts[k + 1].name : text.size();
    const std::string_view whole(text);
    std::string_view value = trim(whole.substr(
        starts[k].equals + 1, std::max(end, starts[k].equals + 1) - (starts[k].equals + 1)));
    if (!value.empty() && value.back() == ',') value = trim(value.substr(0, value.size() - 1));
    std::string name =
        lower_spice(trim(whole.substr(starts[k].name, starts[k].equals - starts[k].name)));
    if (value.empty()) {
      refuse(line.place, fmt::format("'{}': parameter {} has no value", text, name));
    }
    parameters.push_back({std::move(name), std::string(value)});
  }
  return parameters;
}

}  // namespace gyrator
