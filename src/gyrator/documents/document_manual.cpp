#include "gyrator/documents/document_manual.hpp"

#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace gyrator {

namespace {

// A key on the way to an object, and the alternatives of its value that the way may lead through.
struct Step {
  std::string name;                // "contact_effects[]"; empty for the file itself
  std::vector<std::string> kinds;  // none: there is nothing to choose
  std::size_t choices = 0;         // how many alternatives there are
};

using Place = std::vector<Step>;

struct Section {
  std::string name;           // the kind, of an alternative
  std::vector<Place> places;  // where such an object stands: "controller.velocity"
  std::string meaning;
  std::vector<std::string> keys;
  std::vector<std::string> rows;  // one for each key
  std::string rules;
  struct Shorter {
    std::vector<std::string> missing;  // keys that an object does not have
    std::vector<Place> places;         // there
  };
  std::vector<Shorter> shorter;
};

using Sections = std::vector<Section>;

std::string escape_cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c == '\n' ? ' ' : c;
  }
  return cell;
}

std::string quote_names(const std::vector<std::string>& names) {
  return names.empty() ? "" : fmt::format("`{}`", join(names, "`, `"));
}

std::string write_default(const Member& member) {
  if (member.is_required) return "required";
  return member.fallback ? fmt::format("`{}`", member.fallback->dump()) : "none";
}

std::string write_allowed(const Member& member) {
  std::string allowed;
  switch (member.kind) {
    case ValueKind::quantity:
    case ValueKind::time:
    case ValueKind::integer:
      allowed = describe_range(member);
      if (member.kind == ValueKind::integer)
        allowed = "whole number" + (allowed.empty() ? "" : " " + allowed);
      break;
    case ValueKind::boolean:
      allowed = "`true`, `false`";
      break;
    case ValueKind::text:
      allowed = "text";
      break;
    case ValueKind::choice:
      allowed = quote_names(member.names);
      break;
    case ValueKind::object:
      allowed = "object, see below";
      break;
    case ValueKind::variant:
      allowed = member.discriminator + " " + quote_names(list_kinds(member));
      break;
    case ValueKind::anything:
      allowed = "any value";
      break;
  }
  return member.is_list ? "list" + (allowed.empty() ? "" : ": " + allowed) : allowed;
}

std::string write_row(const Member& member) {
  const bool has_unit = member.kind == ValueKind::quantity || member.kind == ValueKind::time;
  return fmt::format(
      "| `{}` | {} | {} | {} | {} |\n", member.name,
      has_unit ? fmt::format("{}{}", member.unit.symbol, member.takes_tolerance ? " ±" : "") : "",
      escape_cell(write_default(member)), escape_cell(write_allowed(member)),
      escape_cell(member.meaning));
}

Section make_section(const ObjectSpec& spec, const std::string& name, const Place& place) {
  Section section{name, {place}, spec.meaning, {}, {}, "", {}};
  for (const Member& member : spec.members) {
    section.keys.push_back(member.name);
    section.rows.push_back(write_row(member));
  }
  for (const auto& group : spec.exactly_one) {
    section.rules += fmt::format("\nExactly one of {} must be given.\n", quote_names(group));
  }
  for (const auto& group : spec.at_most_one) {
    section.rules += fmt::format("\nAt most one of {} may be given.\n", quote_names(group));
  }
  return section;
}

// The keys that `part` lacks of `whole`, if that is all the difference between their tables.
std::optional<std::vector<std::string>> find_missing(const Section& whole, const Section& part) {
  if (part.name != whole.name || part.meaning != whole.meaning || part.rules != whole.rules)
    return std::nullopt;
  std::vector<std::string> missing;
  std::size_t at = 0;
  for (std::size_t i = 0; i < whole.rows.size(); ++i) {
    if (at < part.rows.size() && part.rows[at] == whole.rows[i]) {
      ++at;
    } else {
      missing.push_back(whole.keys[i]);
    }
  }
  // Tables that have little in common are clearer apart.
  if (at < part.rows.size() || missing.size() > at) return std::nullopt;
  return missing;
}

void add_section(Sections& sections, Section section) {
  const Place& place = section.places.front();
  for (Section& other : sections) {
    const auto missing = find_missing(other, section);
    if (!missing) continue;
    other.places.push_back(place);
    if (missing->empty()) return;
    for (auto& shorter : other.shorter) {
      if (shorter.missing == *missing) return shorter.places.push_back(place);
    }
    other.shorter.push_back({*missing, {place}});
    return;
  }
  sections.push_back(std::move(section));
}

void add_value(Sections& sections, const Member& member, const Place& place);

void add_object(Sections& sections, const ObjectSpec& spec, const std::string& name,
                const Place& place, const Place& inner_place) {
  add_section(sections, make_section(spec, name, place));
  for (const Member& member : spec.members) {
    Place below = inner_place;
    below.push_back({member.name + (member.is_list ? "[]" : ""), {}, 0});
    add_value(sections, member, below);
  }
}

void add_value(Sections& sections, const Member& member, const Place& place) {
  if (member.kind == ValueKind::object) {
    add_object(sections, member.objects.front(), "", place, place);
  } else if (member.kind == ValueKind::variant) {
    for (const ObjectSpec& spec : member.objects) {
      const std::string kind = fmt::format(R"(`"{}": "{}"`)", member.discriminator, spec.name);
      Place inner = place;
      if (inner.empty()) inner.emplace_back();
      inner.back().kinds = {spec.name};
      inner.back().choices = member.objects.size();
      add_object(sections, spec, kind, place, inner);
    }
  }
}

// Adds the kinds of `other` to `place` if together they are all ways of choosing at one step.
bool merge(Place& place, const Place& other) {
  if (place.size() != other.size()) return false;
  Step* differing = nullptr;
  const Step* added = nullptr;
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (place[i].name != other[i].name || place[i].choices != other[i].choices) return false;
    if (place[i].kinds == other[i].kinds) continue;
    if (differing) return false;
    differing = &place[i];
    added = &other[i];
  }
  if (!differing) return true;
  for (const std::string& kind : added->kinds) {
    auto& kinds = differing->kinds;
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(kind);
  }
  return true;
}

std::string write_place(const Place& place) {
  std::string text;
  for (const Step& step : place) {
    if (!text.empty()) text += ".";
    text += step.name;
    if (step.kinds.empty()) continue;
    const bool is_any = step.choices > 1 && step.kinds.size() == step.choices;
    text += "(" + (is_any ? "*" : join(step.kinds, ", ")) + ")";
  }
  return text;
}

// Merges two of the places, if any two are alike enough.
bool merge_any(std::vector<Place>& places) {
  for (auto one = places.begin(); one != places.end(); ++one) {
    for (auto other = std::next(one); other != places.end(); ++other) {
      if (!merge(*one, *other)) continue;
      places.erase(other);
      return true;
    }
  }
  return false;
}

// Places that differ in one choice only are written as one.
std::string write_places(std::vector<Place> places) {
  while (merge_any(places)) {
  }
  std::vector<std::string> texts;
  for (const Place& place : places) texts.push_back(write_place(place));
  return quote_names(texts);
}

std::string write_section(const Section& section) {
  std::vector<std::string> parts;
  if (!section.places.front().empty()) parts.push_back(write_places(section.places));
  if (!section.name.empty()) parts.push_back(section.name);
  if (parts.empty()) parts.emplace_back("The file");
  std::string text = fmt::format("### {}\n\n", join(parts, " with "));
  if (!section.meaning.empty()) text += section.meaning + "\n\n";
  if (section.rows.empty()) return text + "No further keys.\n";
  text += "| key | unit | default | allowed | meaning |\n| --- | --- | --- | --- | --- |\n" +
          join(section.rows, "") + section.rules;
  for (const auto& shorter : section.shorter) {
    text += fmt::format("\nIn {} without {}.\n", write_places(shorter.places),
                        quote_names(shorter.missing));
  }
  return text;
}

}  // namespace

std::string write_manual_table(const ObjectSpec& spec) {
  return write_manual_table(member::object("", spec));
}

std::string write_manual_table(const Member& root) {
  Sections sections;
  add_value(sections, root, {});
  std::string text;
  for (const Section& section : sections) {
    if (!text.empty()) text += "\n";
    text += write_section(section);
  }
  return text;
}

}  // namespace gyrator
