#include "gyrator/documents/document_member.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <charconv>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorCode::bad_input, "", message);
}

std::vector<std::string> split(std::string_view path) {
  std::vector<std::string> keys;
  for (std::size_t at = 0; at <= path.size();) {
    const std::size_t dot = std::min(path.find('.', at), path.size());
    keys.emplace_back(path.substr(at, dot - at));
    at = dot + 1;
  }
  return keys;
}

bool is_object(const Member& member) {
  return member.kind == ValueKind::object || member.kind == ValueKind::variant;
}

// Of a variant the alternative that the document has taken.
const ObjectSpec& find_spec(const Member& member, const json& value) {
  if (member.kind == ValueKind::object) return member.objects.front();
  const std::string kind = value[member.discriminator];
  return *std::find_if(member.objects.begin(), member.objects.end(),
                       [&](const ObjectSpec& spec) { return spec.name == kind; });
}

std::vector<std::string> list_keys(const ObjectSpec& spec) {
  std::vector<std::string> keys;
  for (const Member& member : spec.members) keys.push_back(member.name);
  return keys;
}

class Walk {
 public:
  Walk(const json& normal, Member root) : value_(&normal), member_(std::move(root)) {}

  void enter(const std::string& key) {
    if (member_.is_list) return enter_item(key);
    if (!is_object(member_)) refuse(fmt::format("'{}' is a value and has no '{}'", name_, key));
    if (value_->is_null()) {
      refuse(fmt::format("the model has no '{}': write one into it, to start from", name_));
    }
    const ObjectSpec& spec = find_spec(member_, *value_);
    if (!member_.discriminator.empty() && key == member_.discriminator) {
      refuse(
          fmt::format("'{}' decides which other keys there are and cannot vary: make a model of "
                      "each",
                      key));
    }
    const auto found = std::find_if(spec.members.begin(), spec.members.end(),
                                    [&](const Member& m) { return m.name == key; });
    if (found == spec.members.end()) refuse(describe_unknown_name("key", key, list_keys(spec)));
    Member next = *found;
    value_ = &(*value_)[key];
    go(key, std::move(next));
  }

  FoundMember finish() const {
    if (member_.is_list) {
      refuse(fmt::format("'{}' is a list of {}: name one by its number, from 0", name_,
                         value_->size()));
    }
    if (is_object(member_)) {
      refuse(fmt::format(
          "'{}' has several values: name one of them{}", name_,
          value_->is_null() ? "" : ", " + join(list_keys(find_spec(member_, *value_)))));
    }
    return {pointer_, member_};
  }

 private:
  void enter_item(const std::string& key) {
    std::size_t index = 0;
    const char* end = key.data() + key.size();
    const auto read = std::from_chars(key.data(), end, index);
    const std::size_t size = value_->is_null() ? 0 : value_->size();
    if (size == 0) refuse(fmt::format("the list '{}' is empty", name_));
    if (read.ec != std::errc{} || read.ptr != end || index >= size) {
      refuse(fmt::format("'{}' is no item of '{}': a number from 0 to {} is expected", key, name_,
                         size - 1));
    }
    Member item = member_;
    item.is_list = false;
    value_ = &(*value_)[index];
    pointer_ /= index;
    name_ += "." + key;
    member_ = std::move(item);
  }

  void go(const std::string& key, Member next) {
    pointer_ /= key;
    name_ += (name_.empty() ? "" : ".") + key;
    member_ = std::move(next);
  }

  const json* value_;
  Member member_;
  json::json_pointer pointer_;
  std::string name_;
};

}  // namespace

FoundMember find_member(const json& normal, const Member& root, std::string_view path) {
  if (path.empty()) refuse("a key's path is missing, such as damping.0.capacitance");
  Walk walk(normal, root);
  for (const std::string& key : split(path)) walk.enter(key);
  return walk.finish();
}

}  // namespace gyrator
