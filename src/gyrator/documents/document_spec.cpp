#include "gyrator/documents/document_spec.hpp"

#include "gyrator/core/text.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/core.h>

namespace gyrator {

Member Member::required() && {
  is_required = true;
  return std::move(*this);
}

Member Member::by_default(nlohmann::json value) && {
  fallback = std::move(value);
  return std::move(*this);
}

Member Member::above(double value, std::string reason) && {
  low = Bound{value, true, std::move(reason)};
  return std::move(*this);
}

Member Member::at_least(double value, std::string reason) && {
  low = Bound{value, false, std::move(reason)};
  return std::move(*this);
}

Member Member::below(double value, std::string reason) && {
  high = Bound{value, true, std::move(reason)};
  return std::move(*this);
}

Member Member::at_most(double value, std::string reason) && {
  high = Bound{value, false, std::move(reason)};
  return std::move(*this);
}

Member Member::list(std::size_t min, std::optional<std::size_t> max) && {
  is_list = true;
  min_items = min;
  max_items = max;
  return std::move(*this);
}

Member Member::kind_by_default(std::string kind_name) && {
  default_kind = std::move(kind_name);
  return std::move(*this);
}

Member Member::doc(std::string sentence) && {
  meaning = std::move(sentence);
  return std::move(*this);
}

namespace {

std::string with_unit(double value, const Member& member) {
  const bool has_unit = member.kind == ValueKind::quantity || member.kind == ValueKind::time;
  if (!has_unit || member.unit.symbol == "1") return format_number(value);
  return fmt::format("{} {}", format_number(value), member.unit.symbol);
}

std::string describe_value(const Member& member) {
  switch (member.kind) {
    case ValueKind::quantity:
    case ValueKind::time:
      if (member.unit.symbol == "1") return "number, such as 0.05 or \"5 %\"";
      return fmt::format("{} [{}], such as \"{}\"", member.unit.name, member.unit.symbol,
                         member.unit.example);
    case ValueKind::integer:
      return "whole number";
    case ValueKind::boolean:
      return "true or false";
    case ValueKind::text:
      return "text";
    case ValueKind::choice:
      return "one of " + join(member.names);
    case ValueKind::object: {
      std::vector<std::string> names;
      for (const Member& inner : member.objects.front().members) names.push_back(inner.name);
      return fmt::format("object {{{}}}", join(names));
    }
    case ValueKind::variant:
      return fmt::format("object with \"{}\" one of {}", member.discriminator,
                         join(list_kinds(member)));
    case ValueKind::anything:
      return "value";
  }
  return {};
}

}  // namespace

ObjectSpec allow_tolerances(ObjectSpec spec, const std::vector<std::string>& but_not) {
  for (Member& member : spec.members) {
    if (std::find(but_not.begin(), but_not.end(), member.name) != but_not.end()) continue;
    member.takes_tolerance = member.kind == ValueKind::quantity;
    for (ObjectSpec& inner : member.objects) inner = allow_tolerances(std::move(inner), but_not);
  }
  return spec;
}

std::string describe_expected(const Member& member) {
  std::string value = describe_value(member);
  const bool is_noun = member.kind != ValueKind::boolean && member.kind != ValueKind::choice;
  const bool vowel = std::string_view("aeiou").find(value.front()) != std::string_view::npos;
  if (is_noun) value.insert(0, vowel ? "an " : "a ");
  if (!member.is_list) return value;
  std::string size;
  if (member.min_items > 0) size = fmt::format(" of at least {}", member.min_items);
  if (member.max_items) {
    size += fmt::format("{} at most {}", size.empty() ? " of" : " and", *member.max_items);
  }
  return fmt::format("a list{}, each item {},", size, value);
}

std::string describe_range(const Member& member) {
  std::vector<std::string> sides;
  if (member.low) {
    sides.push_back((member.low->exclusive ? "above " : "at least ") +
                    with_unit(member.low->value, member));
  }
  if (member.high) {
    sides.push_back((member.high->exclusive ? "below " : "at most ") +
                    with_unit(member.high->value, member));
  }
  return join(sides, " and ");
}

std::vector<std::string> list_kinds(const Member& variant) {
  std::vector<std::string> kinds;
  for (const ObjectSpec& object : variant.objects) kinds.push_back(object.name);
  return kinds;
}

namespace member {

namespace {

Member make_member(std::string name, ValueKind kind) {
  Member member;
  member.name = std::move(name);
  member.kind = kind;
  return member;
}

}  // namespace

Member quantity(std::string name, const Unit& unit) {
  Member member = make_member(std::move(name), ValueKind::quantity);
  member.unit = unit;
  return member;
}

Member number(std::string name) {
  return quantity(std::move(name), dimension::none);
}

Member time(std::string name) {
  Member member = make_member(std::move(name), ValueKind::time);
  member.unit = dimension::time;
  return member;
}

Member integer(std::string name) {
  return make_member(std::move(name), ValueKind::integer);
}

Member boolean(std::string name) {
  return make_member(std::move(name), ValueKind::boolean);
}

Member text(std::string name) {
  return make_member(std::move(name), ValueKind::text);
}

Member choice(std::string name, std::vector<std::string> names) {
  Member member = make_member(std::move(name), ValueKind::choice);
  member.names = std::move(names);
  return member;
}

Member object(std::string name, ObjectSpec object) {
  Member member = make_member(std::move(name), ValueKind::object);
  member.objects.push_back(std::move(object));
  return member;
}

Member variant(std::string name, std::vector<ObjectSpec> alternatives, std::string discriminator) {
  Member member = make_member(std::move(name), ValueKind::variant);
  member.objects = std::move(alternatives);
  member.discriminator = std::move(discriminator);
  return member;
}

Member anything(std::string name) {
  return make_member(std::move(name), ValueKind::anything);
}

}  // namespace member

}  // namespace gyrator
