#include "gyrator/regression/answer_path.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <optional>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

enum class StepKind { key, number, match, every, reduce };

struct Step {
  StepKind kind = StepKind::key;
  std::string text;  // key, member to match, or "#…"
  std::string value;
  std::size_t number = 0;
};

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorCode::bad_input, "", message);
}

std::optional<std::size_t> read_number(std::string_view text) {
  std::size_t number = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  if (read.ec != std::errc{} || read.ptr != end) return std::nullopt;
  return number;
}

class PathReader {
 public:
  explicit PathReader(std::string_view path) : path_(path) {}

  std::vector<Step> read() {
    std::vector<Step> steps;
    while (true) {
      read_step(steps);
      if (at_ == path_.size()) return steps;
      ++at_;  // the dot
    }
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    refuse(fmt::format("'{}': {}", path_, message));
  }

  void read_step(std::vector<Step>& steps) {
    const std::size_t end = std::min(path_.find_first_of(".[", at_), path_.size());
    const std::string_view key = path_.substr(at_, end - at_);
    at_ = end;
    if (key.empty()) fail("a name is missing: members are separated by one '.'");
    if (key.front() == '#') {
      read_reduction(std::string(key), steps);
    } else if (const auto number = read_number(key)) {
      steps.push_back({StepKind::number, {}, {}, *number});
    } else {
      steps.push_back({StepKind::key, std::string(key), {}, 0});
    }
    while (at_ < path_.size() && path_[at_] == '[') read_bracket(steps);
    if (at_ < path_.size() && path_[at_] != '.') fail("after ']' follows '.', '[' or the end");
  }

  void read_reduction(std::string key, std::vector<Step>& steps) {
    const std::vector<std::string> known{"#", "#min", "#max", "#first", "#last"};
    if (std::find(known.begin(), known.end(), key) == known.end())
      fail(describe_unknown_name("figure of a list", key, known));
    if (at_ != path_.size()) fail(fmt::format("'{}' ends a path", key));
    steps.push_back({StepKind::reduce, std::move(key), {}, 0});
  }

  void read_bracket(std::vector<Step>& steps) {
    const std::size_t close = path_.find(']', at_);
    if (close == std::string_view::npos) fail("']' is missing");
    const std::string_view inner = path_.substr(at_ + 1, close - at_ - 1);
    at_ = close + 1;
    const std::size_t equals = inner.find('=');
    if (inner == "*") {
      steps.push_back({StepKind::every, {}, {}, 0});
    } else if (const auto number = read_number(inner)) {
      steps.push_back({StepKind::number, {}, {}, *number});
    } else if (equals != std::string_view::npos && equals > 0) {
      steps.push_back({StepKind::match, std::string(inner.substr(0, equals)),
                       std::string(inner.substr(equals + 1)), 0});
    } else {
      fail(fmt::format("[{}]: a number, * or member=value is expected", inner));
    }
  }

  std::string_view path_;
  std::size_t at_ = 0;
};

std::string describe(const json& value) {
  if (value.is_array()) return fmt::format("a list of {}", value.size());
  if (value.is_object()) return "an object";
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

bool matches(const json& value, const std::string& text) {
  if (value.is_string()) return value.get<std::string>() == text;
  if (value.is_boolean()) return text == (value.get<bool>() ? "true" : "false");
  if (!value.is_number()) return value.is_null() && text == "null";
  const auto decimal = find_decimal(text);
  return decimal && decimal->length == text.size() && std::strtod(text.c_str(), nullptr) == value;
}

// The smallest or largest number, through lists of lists; null where there is none.
json find_extreme(const json& value, const std::string& how) {
  if (value.is_number() || value.is_null()) return value;
  if (!value.is_array())
    refuse(fmt::format("{} is of lists of numbers: found {}", how, describe(value)));
  json best;
  for (const json& item : value) {
    const json other = find_extreme(item, how);
    if (other.is_null()) continue;
    if (best.is_null() || (how == "#min" ? other < best : other > best)) best = other;
  }
  return best;
}

json reduce(const json& list, const std::string& how) {
  if (!list.is_array()) refuse(fmt::format("{} is of lists: found {}", how, describe(list)));
  if (how == "#") return list.size();
  if (list.empty()) refuse(fmt::format("{}: the list is empty", how));
  if (how == "#first") return list.front();
  return how == "#last" ? list.back() : find_extreme(list, how);
}

json walk(const json& value, const std::vector<Step>& steps, std::size_t next) {
  if (next == steps.size()) return value;
  const Step& step = steps[next];
  if (step.kind == StepKind::key) {
    if (!value.is_object())
      refuse(fmt::format("has no '{}': found {}", step.text, describe(value)));
    const auto found = value.find(step.text);
    if (found != value.end()) return walk(*found, steps, next + 1);
    std::vector<std::string> keys;
    for (const auto& item : value.items()) keys.push_back(item.key());
    refuse(describe_unknown_name("member", step.text, keys));
  }
  if (!value.is_array()) refuse(fmt::format("a list is expected: found {}", describe(value)));
  if (step.kind == StepKind::number) {
    if (step.number >= value.size())
      refuse(fmt::format("[{}]: the list has {}, from 0", step.number,
                         describe_count(value.size(), "item")));
    return walk(value[step.number], steps, next + 1);
  }
  if (step.kind == StepKind::every) {
    json all = json::array();
    for (const json& item : value) all.push_back(walk(item, steps, next + 1));
    return all;
  }
  std::vector<std::string> known;
  for (const json& item : value) {
    if (!item.is_object() || !item.contains(step.text)) continue;
    if (matches(item[step.text], step.value)) return walk(item, steps, next + 1);
    const json& other = item[step.text];
    known.push_back(other.is_string() ? other.get<std::string>() : describe(other));
  }
  refuse(describe_unknown_name(step.text, step.value, known));
}

}  // namespace

json find_in_answer(const json& answer, std::string_view path) {
  std::vector<Step> steps = PathReader(path).read();
  try {
    if (steps.back().kind != StepKind::reduce) return walk(answer, steps, 0);
    const std::string how = steps.back().text;
    steps.pop_back();
    return reduce(walk(answer, steps, 0), how);
  } catch (const Error& error) {
    refuse(fmt::format("'{}': {}", path, error.message()));
  }
}

void check_answer_path(std::string_view path) {
  if (!path.starts_with("set.")) PathReader(path).read();
}

}  // namespace gyrator
