#pragma once

#include "gyrator/core/quantity.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

struct ObjectSpec;

enum class ValueKind {
  quantity,  ///< a number in SI units or a text with a unit → number in SI units
  time,      ///< the same, kept exact → text "num/den" in seconds
  integer,
  boolean,
  text,
  choice,   ///< a text out of a list of names
  object,   ///< a sub-object with members of its own
  variant,  ///< an object whose members depend on one of them, "kind"
  anything  ///< any JSON value, handed on as it is
};

/// One side of the allowed range, in SI units.
struct Bound {
  double value = 0;
  bool exclusive = false;
  std::string reason;  ///< why, for the message: "a passive winding loses energy"
};

/// One key of a JSON object: the reader, the JSON Schema and the manual follow from it.
///
/// Written with the builders below, which read like the sentence they stand for:
///
///   member::quantity("resistance", dimension::resistance).required().above(0).doc("Winding.")
///   member::variant("damping", {resistor, rc}).list().doc("Across the terminals.")
///
/// A member is required, or has a default, or is optional without one: absent then reads as null
/// (and may be written as null).
struct Member {
  std::string name;
  ValueKind kind = ValueKind::anything;
  Unit unit = dimension::none;           ///< of a quantity
  std::vector<std::string> names;        ///< of a choice
  std::vector<ObjectSpec> objects;       ///< the object, or the alternatives of a variant
  std::string discriminator;             ///< of a variant: the key that tells which, "kind"
  std::string default_kind;              ///< of a variant: taken if the discriminator is absent
  bool is_list = false;                  ///< a JSON list of such values
  std::size_t min_items = 0;             ///< of the list
  std::optional<std::size_t> max_items;  ///< of the list
  bool is_required = false;
  std::optional<nlohmann::json> fallback;  ///< the default, written as a user would
  std::optional<Bound> low;                ///< of a quantity, time or integer
  std::optional<Bound> high;
  bool takes_tolerance = false;  ///< of a quantity: "5 ohm ± 5 %" is one (core/tolerance.hpp)
  std::string meaning;           ///< one sentence

  [[nodiscard]] Member required() &&;
  [[nodiscard]] Member by_default(nlohmann::json value) &&;
  [[nodiscard]] Member above(double value, std::string reason = {}) &&;
  [[nodiscard]] Member at_least(double value, std::string reason = {}) &&;
  [[nodiscard]] Member below(double value, std::string reason = {}) &&;
  [[nodiscard]] Member at_most(double value, std::string reason = {}) &&;
  [[nodiscard]] Member list(std::size_t min = 0, std::optional<std::size_t> max = {}) &&;
  [[nodiscard]] Member kind_by_default(std::string name) &&;
  [[nodiscard]] Member doc(std::string sentence) &&;

  /// Absent reads as null: neither required nor with a default.
  bool is_nullable() const { return !is_required && !fallback; }
};

/// A JSON object: what it is, its members, and which of them exclude one another.
struct ObjectSpec {
  std::string name;  ///< its kind, as an alternative of a variant; else a title
  std::string meaning;
  std::vector<Member> members{};
  std::vector<std::vector<std::string>> exactly_one{};  ///< of each group one member must be given
  std::vector<std::vector<std::string>> at_most_one{};  ///< of each group one member may be given
};

/// The object with tolerances allowed in all its quantities, and in those of objects inside, but
/// for members of these names.
ObjectSpec allow_tolerances(ObjectSpec spec, const std::vector<std::string>& but_not);

/// What a member expects, for messages: "a resistance [ohm], such as "1.5 ohm"", "one of a, b".
std::string describe_expected(const Member& member);

/// The allowed range of a member with its unit, "above 0 ohm and at most 1000 ohm"; else empty.
std::string describe_range(const Member& member);

/// The names of the objects: the kinds of a variant.
std::vector<std::string> list_kinds(const Member& variant);

/// Starts a Member; the fluent functions above complete it.
namespace member {

Member quantity(std::string name, const Unit& unit);
/// A pure number; "5 %" is one.
Member number(std::string name);
Member time(std::string name);
Member integer(std::string name);
Member boolean(std::string name);
Member text(std::string name);
Member choice(std::string name, std::vector<std::string> names);
Member object(std::string name, ObjectSpec object);
/// The discriminator is a key of each alternative's object and is not listed among its members.
Member variant(std::string name, std::vector<ObjectSpec> alternatives,
               std::string discriminator = "kind");
Member anything(std::string name);

}  // namespace member

}  // namespace gyrator
