#include "gyrator/documents/document_reader.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/rational.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/core.h>

namespace gyrator {

namespace {

using nlohmann::json;
using Pointer = nlohmann::json::json_pointer;

std::vector<std::string> list_keys(const json& object) {
  std::vector<std::string> keys;
  for (const auto& item : object.items()) keys.push_back(item.key());
  return keys;
}

std::string shorten(const std::string& text) {
  constexpr std::size_t longest = 60;
  if (text.size() <= longest) return text;
  std::size_t end = longest;
  while ((static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;  // whole characters
  return text.substr(0, end) + "…";
}

// As many whole names as fit.
std::string shorten(const std::vector<std::string>& names) {
  constexpr std::size_t longest = 60;
  std::string text;
  for (const std::string& name : names) {
    if (!text.empty() && text.size() + name.size() > longest) return text + ", …";
    text += (text.empty() ? "" : ", ") + shorten(name);
  }
  return text;
}

std::string dump(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string describe_found(const json& value) {
  if (value.is_string()) return "the text " + shorten(dump(value));
  if (value.is_array()) return fmt::format("a list of {}", value.size());
  if (value.is_object()) return fmt::format("an object {{{}}}", shorten(list_keys(value)));
  if (value.is_number()) return "the number " + dump(value);
  return dump(value);
}

class Reader {
 public:
  explicit Reader(const std::string& file) : file_(file) {}

  std::vector<GivenTolerance> take_tolerances() { return std::move(tolerances_); }

  json read_member(const json& value, const Member& member, const Pointer& at) {
    if (!member.is_list) return read_value(value, member, at);
    const bool fits = value.is_array() && value.size() >= member.min_items &&
                      (!member.max_items || value.size() <= *member.max_items);
    if (!fits) refuse_type(value, member, at);
    Member item = member;  // what is said of one of them
    item.is_list = false;
    json items = json::array();
    for (std::size_t i = 0; i < value.size(); ++i) {
      items.push_back(read_value(value[i], item, at / i));
    }
    return items;
  }

 private:
  [[noreturn]] void refuse(const Pointer& at, const std::string& message) const {
    const std::string pointer = at.empty() ? "/" : at.to_string();
    throw Error(ErrorCode::bad_input, file_.empty() ? pointer : file_ + ": " + pointer, message);
  }

  [[noreturn]] void refuse_type(const json& value, const Member& member, const Pointer& at) const {
    refuse(at, fmt::format("found {}: {} is expected", describe_found(value),
                           describe_expected(member)));
  }

  // Runs a parser that knows no place, and puts the place into its errors.
  template <class Parse>
  auto place(const Pointer& at, Parse parse) const {
    try {
      return parse();
    } catch (const Error& error) {
      refuse(at, error.message());
    }
  }

  json read_value(const json& value, const Member& member, const Pointer& at) {
    switch (member.kind) {
      case ValueKind::quantity:
        return read_quantity(value, member, at);
      case ValueKind::time:
        return read_time(value, member, at);
      case ValueKind::integer:
        return read_integer(value, member, at);
      case ValueKind::boolean:
        if (!value.is_boolean()) refuse_type(value, member, at);
        return value;
      case ValueKind::text:
        if (!value.is_string()) refuse_type(value, member, at);
        return value;
      case ValueKind::choice:
        return read_choice(value, member, at);
      case ValueKind::object:
        return read_object(value, member.objects.front(), member, at);
      case ValueKind::variant:
        return read_variant(value, member, at);
      case ValueKind::anything:
        return value;
    }
    return {};
  }

  json read_quantity(const json& value, const Member& member, const Pointer& at) {
    double number = 0;
    if (value.is_number()) {
      number = value.get<double>();
      if (!std::isfinite(number)) {
        refuse(at, format_number(number) + ": not a finite number, which a quantity must be");
      }
    } else if (value.is_string() && has_tolerance(value.get<std::string>())) {
      return read_toleranced(value, member, at);
    } else if (value.is_string()) {
      number = place(at, [&] { return parse_value(value.get<std::string>(), member.unit); });
    } else {
      refuse_type(value, member, at);
    }
    check_bounds(number, value, member, at);
    return number;
  }

  json read_toleranced(const json& value, const Member& member, const Pointer& at) {
    const std::string text = value.get<std::string>();
    if (!member.takes_tolerance) refuse_tolerance(text, member, at);
    const TolerancedValue given =
        place(at, [&] { return parse_toleranced_value(text, member.unit); });
    check_bounds(given.nominal, value, member, at);
    if (given.low == given.high) return given.nominal;
    check_bounds(given.low, value, member, at, "at its low end ");
    check_bounds(given.high, value, member, at, "at its high end ");
    tolerances_.push_back({at.to_string(), member.unit, given, text});
    return given.nominal;
  }

  [[noreturn]] void refuse_tolerance(const std::string& text, const Member& member,
                                     const Pointer& at) const {
    refuse(at, fmt::format("'{}': no tolerance is possible here: write one value, such as \"{}\"",
                           shorten(text), member.unit.example));
  }

  json read_time(const json& value, const Member& member, const Pointer& at) const {
    if (!value.is_number() && !value.is_string()) refuse_type(value, member, at);
    if (value.is_string() && has_tolerance(value.get<std::string>()))
      refuse_tolerance(value.get<std::string>(), member, at);
    // An integer too goes through its text: it may be larger than a Rational holds.
    const Rational time = place(at, [&] {
      if (value.is_number_float()) return Rational::from_double(value.get<double>());
      return value.is_string() ? parse_time(value.get<std::string>())
                               : Rational::from_decimal(dump(value));
    });
    check_bounds(time.to_double(), value, member, at);
    return time.to_string();
  }

  json read_integer(const json& value, const Member& member, const Pointer& at) const {
    constexpr double exact = 0x1p53;
    std::int64_t number = 0;
    if (value.is_number_float()) {
      // 3.0 is a whole number in JSON, which knows no types of numbers.
      const double given = value.get<double>();
      if (given != std::floor(given) || std::abs(given) > exact) refuse_type(value, member, at);
      number = static_cast<std::int64_t>(given);
    } else if (value.is_number_unsigned() && value.get<std::uint64_t>() > INT64_MAX) {
      refuse(at, fmt::format("{}: a whole number has at most 63 bits", dump(value)));
    } else if (value.is_number_integer()) {
      number = value.get<std::int64_t>();
    } else {
      refuse_type(value, member, at);
    }
    check_bounds(static_cast<double>(number), value, member, at);
    return number;
  }

  // `which` end of a range it is, "at its low end ".
  void check_bounds(double number, const json& given, const Member& member, const Pointer& at,
                    std::string_view which = "") const {
    const auto is_inside = [number](const std::optional<Bound>& bound, double side) {
      if (!bound) return true;
      return bound->exclusive ? side * number > side * bound->value
                              : side * number >= side * bound->value;
    };
    const bool above = is_inside(member.low, 1);
    if (above && is_inside(member.high, -1)) return;
    const std::string& reason = above ? member.high->reason : member.low->reason;
    const std::string unit =
        member.unit.symbol == "1" ? "" : fmt::format(" {}", member.unit.symbol);
    const std::string value = format_number(number) + unit;
    refuse(at, fmt::format(
                   "{}: must be {}{}",
                   given.is_string() ? fmt::format("{} is {}{}", dump(given), which, value) : value,
                   describe_range(member), reason.empty() ? "" : ", for " + reason));
  }

  json read_choice(const json& value, const Member& member, const Pointer& at) const {
    if (!value.is_string()) refuse_type(value, member, at);
    check_name(value.get<std::string>(), member.names, "name", at);
    return value;
  }

  void check_name(const std::string& name, const std::vector<std::string>& known,
                  std::string_view what, const Pointer& at) const {
    if (std::find(known.begin(), known.end(), name) != known.end()) return;
    refuse(at, describe_unknown_name(what, shorten(name), known));
  }

  json read_variant(const json& value, const Member& member, const Pointer& at) {
    const std::vector<std::string> kinds = list_kinds(member);
    if (!value.is_object()) {
      const bool is_kind = value.is_string() && std::find(kinds.begin(), kinds.end(),
                                                          value.get<std::string>()) != kinds.end();
      const std::string hint =
          is_kind ? fmt::format("; write {{\"{}\": {}}}", member.discriminator, dump(value)) : "";
      refuse(at, fmt::format("found {}: {} is expected{}", describe_found(value),
                             describe_expected(member), hint));
    }
    std::string kind = member.default_kind;
    if (const auto given = value.find(member.discriminator); given != value.end()) {
      if (!given->is_string()) {
        refuse(at / member.discriminator,
               fmt::format("found {}: one of {} is expected", describe_found(*given), join(kinds)));
      }
      kind = given->get<std::string>();
      check_name(kind, kinds, member.discriminator, at / member.discriminator);
    }
    if (kind.empty()) {
      refuse(at, fmt::format("the key '{}' is missing: one of {} is expected", member.discriminator,
                             join(kinds)));
    }
    const auto spec =
        std::find_if(member.objects.begin(), member.objects.end(),
                     [&kind](const ObjectSpec& object) { return object.name == kind; });
    json object = read_object(value, *spec, member, at);
    object[member.discriminator] = kind;
    return object;
  }

  // `owner` is the member whose value this is: of a variant it has the other alternatives too.
  json read_object(const json& value, const ObjectSpec& spec, const Member& owner,
                   const Pointer& at) {
    if (!value.is_object()) refuse_type(value, owner, at);
    check_keys(value, spec, owner, at);
    for (const auto& group : spec.exactly_one) check_group(value, group, true, at);
    for (const auto& group : spec.at_most_one) check_group(value, group, false, at);

    json object = json::object();
    for (const Member& member : spec.members) {
      const auto given = value.find(member.name);
      const bool is_given = given != value.end() && !(member.is_nullable() && given->is_null());
      if (is_given) {
        object[member.name] = read_member(*given, member, at / member.name);
      } else if (member.is_required) {
        const std::string present = value.empty() ? "none" : shorten(list_keys(value));
        refuse(at, fmt::format("the key '{}' is missing: {} is expected; keys given: {}",
                               member.name, describe_expected(member), present));
      } else {
        object[member.name] =
            member.fallback ? read_member(*member.fallback, member, at / member.name) : json();
      }
    }
    return object;
  }

  void check_keys(const json& value, const ObjectSpec& spec, const Member& owner,
                  const Pointer& at) const {
    std::vector<std::string> known;
    if (!owner.discriminator.empty()) known.push_back(owner.discriminator);
    for (const Member& member : spec.members) known.push_back(member.name);

    for (const std::string& key : list_keys(value)) {
      if (at.empty() && key == "$schema") continue;
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      const std::vector<std::string> owners = list_owners(owner.objects, key);
      const std::string owners_of_key =
          owners.empty()
              ? ""
              : fmt::format(" for '{}' (it belongs to '{}')", spec.name, join(owners, "', '"));
      refuse(at / key, fmt::format("unknown key '{}'{}: allowed: {}{}{}", shorten(key),
                                   owners_of_key, known.empty() ? "none" : join(known),
                                   owners.empty() ? suggest_name(key, known) : "",
                                   suggest_member(key, spec)));
    }
  }

  // The kinds that have the key.
  static std::vector<std::string> list_owners(const std::vector<ObjectSpec>& objects,
                                              const std::string& key) {
    std::vector<std::string> owners;
    for (const ObjectSpec& object : objects) {
      const bool has_key = std::any_of(object.members.begin(), object.members.end(),
                                       [&key](const Member& m) { return m.name == key; });
      if (has_key) owners.push_back(object.name);
    }
    return owners;
  }

  // Where a key stands too far out: the member that it belongs into, if there is only one.
  static std::string suggest_member(const std::string& key, const ObjectSpec& spec) {
    std::string place;
    for (const Member& member : spec.members) {
      if (list_owners(member.objects, key).empty()) continue;
      if (!place.empty()) return "";
      place = member.name;
    }
    return place.empty() ? "" : fmt::format("; put it into '{}'", place);
  }

  void check_group(const json& value, const std::vector<std::string>& group, bool needs_one,
                   const Pointer& at) const {
    std::vector<std::string> given;
    for (const std::string& name : group) {
      const auto found = value.find(name);
      if (found != value.end() && !found->is_null()) given.push_back(name);
    }
    if (given.size() == 1 || (given.empty() && !needs_one)) return;
    refuse(at, fmt::format("{}: {} be given of {}",
                           given.empty() ? "none is given" : join(given, " and ") + " are given",
                           needs_one ? "exactly one must" : "at most one may", join(group)));
  }

  const std::string& file_;
  std::vector<GivenTolerance> tolerances_;
};

}  // namespace

json read_document(const json& document, const ObjectSpec& spec, const std::string& file) {
  return read_document(document, member::object("", spec), file);
}

json read_document(const json& document, const Member& root, const std::string& file) {
  return read_document_with_tolerances(document, root, file).normal;
}

ReadDocument read_document_with_tolerances(const json& document, const Member& root,
                                           const std::string& file) {
  Reader reader(file);
  json normal = reader.read_member(document, root, Pointer{});
  return {std::move(normal), reader.take_tolerances()};
}

}  // namespace gyrator
