#include "gyrator/documents/shared_schema.hpp"

#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace gyrator {

namespace {

using Json = nlohmann::ordered_json;

// Keys from the root down, each with what is chosen there: "rotary", "controller.wave", "velocity".
using Path = std::vector<std::string>;

// Characters of a part's text. Below it, a reference is hardly shorter than what it refers to.
constexpr std::size_t smallest_shared = 120;

const std::string item = ".item";

struct Part {
  const Json* schema = nullptr;
  Path path;                    // of its first use
  std::set<std::string> roots;  // alternatives of the root under which it is used
  int uses = 0;                 // counting a part that is shared itself once
  std::string name;             // if it is shared
};

// What tells an alternative from the others: the one value that its discriminator may have.
std::string find_label(const Json& alternative) {
  if (alternative.contains("properties")) {
    for (const auto& [key, value] : alternative["properties"].items()) {
      if (value.contains("const") && value["const"].is_string())
        return value["const"].get<std::string>();
    }
  }
  if (alternative.contains("type") && alternative["type"].is_string())
    return alternative["type"].get<std::string>();
  return "any";
}

// A path's steps become parts of a URI and of a JSON pointer.
std::string clean(std::string text) {
  for (char& c : text) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-') c = '_';
  }
  return text;
}

Path choose(Path path, const std::string& what) {
  if (path.empty()) return {clean(what)};
  // An alternative of a list's items: "damping.resistor".
  const auto end = path.back().size() - std::min(path.back().size(), item.size());
  if (path.back().substr(end) == item) path.back().resize(end);
  path.back() += "." + clean(what);
  return path;
}

// Calls visit(child, its path) for every part of a schema, Json or const Json.
template <class Schema, class Visit>
void visit_parts(Schema& schema, const Path& path, const Visit& visit) {
  if (schema.contains("properties")) {
    for (auto& [key, value] : schema["properties"].items()) {
      Path below = path;
      below.push_back(clean(key));
      visit(value, below);
    }
  }
  if (schema.contains("items")) visit(schema["items"], choose(path, "item"));
  for (const char* key : {"oneOf", "anyOf"}) {
    if (!schema.contains(key)) continue;
    for (auto& alternative : schema[key]) visit(alternative, choose(path, find_label(alternative)));
  }
}

class Sharing {
 public:
  Sharing(const Json& schema, const std::map<std::string, Json>& named)
      : schema_(schema), has_forms_(schema.contains("oneOf")) {
    for (const auto& [name, part] : named) given_names_[part.dump()] = name;
    visit_parts(schema_, {}, [&](const Json& part, const Path& path) { count(part, path, true); });
    for (const std::string& text : order_) {
      Part& part = parts_[text];
      if (part.uses > 1) shared_.push_back(&part);
    }
    name_parts();
  }

  Json write() const {
    Json schema = expand(schema_);
    for (const Part* part : shared_) schema["$defs"][part->name] = expand(*part->schema);
    return schema;
  }

 private:
  // Inside a part that was met before, nothing is used once more: it will be written once.
  void count(const Json& schema, const Path& path, bool is_use) {
    const std::string text = schema.dump();
    const auto given = given_names_.find(text);
    const bool has_name = given != given_names_.end();
    if ((text.size() < smallest_shared && !has_name) || schema.contains("const")) return;
    const auto [at, is_new] = parts_.try_emplace(text);
    Part& part = at->second;
    if (is_new) {
      order_.push_back(text);
      part.schema = &schema;
      part.path = path;
      if (has_name) part.name = given->second;
    }
    part.roots.insert(path.front());
    if (is_use) ++part.uses;
    visit_parts(schema, path, [&](const Json& child, const Path& below) {
      count(child, below, is_use && is_new);
    });
  }

  // The last `keys` keys of the path, after the form of the document if `with_form`.
  std::string write_name(const Part& part, std::size_t keys, bool with_form) const {
    const std::size_t first = has_forms_ ? 1 : 0;
    const std::size_t start = std::max(first, part.path.size() - std::min(part.path.size(), keys));
    Path steps(part.path.begin() + static_cast<std::ptrdiff_t>(start), part.path.end());
    if (with_form) steps.insert(steps.begin(), part.path.front());
    return join(steps, ".");
  }

  // Names grow until each is the only one of its kind; a form of the document is named only where
  // all uses are in it.
  void name_parts() {
    std::size_t longest = 0;
    for (const Part* part : shared_) longest = std::max(longest, part->path.size());
    std::set<std::string> taken;
    for (const auto& [text, name] : given_names_) taken.insert(name);
    for (std::size_t keys = 1; keys <= longest; ++keys) {
      for (const bool with_form : {false, true}) {
        std::map<std::string, std::vector<Part*>> wanted;
        for (Part* part : shared_) {
          if (!part->name.empty() || (with_form && !(has_forms_ && part->roots.size() == 1)))
            continue;
          wanted[write_name(*part, keys, with_form)].push_back(part);
        }
        for (const auto& [name, parts] : wanted) {
          if (parts.size() == 1 && !name.empty() && taken.insert(name).second)
            parts.front()->name = name;
        }
      }
    }
    for (Part* part : shared_) {
      const std::string name = join(part->path, ".");
      for (int i = 1; part->name.empty(); ++i) {
        const std::string numbered = name + "_" + std::to_string(i);
        if (taken.insert(numbered).second) part->name = numbered;
      }
    }
  }

  Json expand(Json schema) const {
    visit_parts(schema, {}, [&](Json& part, const Path&) { part = refer(part); });
    return schema;
  }

  Json refer(const Json& schema) const {
    const auto at = parts_.find(schema.dump());
    if (at == parts_.end() || at->second.uses < 2) return expand(schema);
    return {{"$ref", "#/$defs/" + at->second.name}};
  }

  const Json& schema_;
  bool has_forms_;
  std::map<std::string, std::string> given_names_;  // by the part's text
  std::map<std::string, Part> parts_;               // by their text
  std::vector<std::string> order_;                  // of first use
  std::vector<Part*> shared_;
};

}  // namespace

nlohmann::ordered_json build_shared_schema(
    const nlohmann::ordered_json& schema,
    const std::map<std::string, nlohmann::ordered_json>& named) {
  return Sharing(schema, named).write();
}

}  // namespace gyrator
