#include "gyrator/documents/document_manual.hpp"

#include "gyrator/core/text.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace gyrator {

namespace {

struct Section {
  std::string name;                 // the kind, of an alternative
  std::vector<std::string> places;  // where such an object stands: "controller.velocity"
  std::string body;
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

std::string write_table(const ObjectSpec& spec) {
  std::string table = spec.meaning.empty() ? "" : spec.meaning + "\n\n";
  if (spec.members.empty()) return table + "No further keys.\n";
  table += "| key | unit | default | allowed | meaning |\n| --- | --- | --- | --- | --- |\n";
  for (const Member& member : spec.members) {
    const bool has_unit = member.kind == ValueKind::quantity || member.kind == ValueKind::time;
    table += fmt::format("| `{}` | {} | {} | {} | {} |\n", member.name,
                         has_unit ? member.unit.symbol : "", escape_cell(write_default(member)),
                         escape_cell(write_allowed(member)), escape_cell(member.meaning));
  }
  for (const auto& group : spec.exactly_one) {
    table += fmt::format("\nExactly one of {} must be given.\n", quote_names(group));
  }
  for (const auto& group : spec.at_most_one) {
    table += fmt::format("\nAt most one of {} may be given.\n", quote_names(group));
  }
  return table;
}

void add_section(Sections& sections, const std::string& name, const std::string& place,
                 const std::string& body) {
  const auto same = std::find_if(sections.begin(), sections.end(), [&](const Section& section) {
    return section.name == name && section.body == body;
  });
  if (same == sections.end()) {
    sections.push_back({name, {place}, body});
  } else if (std::find(same->places.begin(), same->places.end(), place) == same->places.end()) {
    same->places.push_back(place);
  }
}

void add_value(Sections& sections, const Member& member, const std::string& place);

void add_object(Sections& sections, const ObjectSpec& spec, const std::string& name,
                const std::string& place, const std::string& inner_place) {
  add_section(sections, name, place, write_table(spec));
  for (const Member& member : spec.members) {
    add_value(sections, member,
              (inner_place.empty() ? "" : inner_place + ".") + member.name +
                  (member.is_list ? "[]" : ""));
  }
}

void add_value(Sections& sections, const Member& member, const std::string& place) {
  if (member.kind == ValueKind::object) {
    add_object(sections, member.objects.front(), "", place, place);
  } else if (member.kind == ValueKind::variant) {
    for (const ObjectSpec& spec : member.objects) {
      const std::string kind = fmt::format(R"(`"{}": "{}"`)", member.discriminator, spec.name);
      add_object(sections, spec, kind, place, fmt::format("{}({})", place, spec.name));
    }
  }
}

}  // namespace

std::string write_manual_table(const ObjectSpec& spec) {
  return write_manual_table(member::object("", spec));
}

std::string write_manual_table(const Member& root) {
  Sections sections;
  add_value(sections, root, "");
  std::string text;
  for (const Section& section : sections) {
    std::vector<std::string> parts;
    if (!section.places.front().empty()) parts.push_back(quote_names(section.places));
    if (!section.name.empty()) parts.push_back(section.name);
    if (parts.empty()) parts.emplace_back("The file");
    if (!text.empty()) text += "\n";
    text += fmt::format("### {}\n\n{}", join(parts, " with "), section.body);
  }
  return text;
}

}  // namespace gyrator
