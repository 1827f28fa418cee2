#include "gyrator/regression/overridden_model.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/rational.hpp"
#include "gyrator/core/tolerance.hpp"
#include "gyrator/documents/digest.hpp"
#include "gyrator/documents/document_member.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/input_file.hpp"
#include "gyrator/documents/json_text.hpp"
#include "gyrator/studies/model_format.hpp"
#include "gyrator/synthesis/design_spec.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

const Member* find_format(const json& document) {
  if (!document.is_object() || !document.contains("schema") || !document["schema"].is_string())
    return nullptr;
  const std::string schema = document["schema"];
  if (schema.starts_with("gyrator/model/")) return &model_format();
  if (schema.starts_with("gyrator/design/")) return &design_format();
  return nullptr;
}

// Netlists and recordings, wherever they are named; of a design's spec its model.
void visit_files(json& value, const std::function<void(json&)>& visit) {
  if (!value.is_structured()) return;
  for (const auto& [key, inner] : value.items()) {
    if ((key == "file" || key == "model") && inner.is_string()) visit(inner);
    visit_files(inner, visit);
  }
}

// "damping.0.capacitance" → /damping/0/capacitance
json::json_pointer pointer_of(const std::string& path) {
  json::json_pointer pointer;
  for (std::size_t at = 0; at <= path.size();) {
    const std::size_t dot = std::min(path.find('.', at), path.size());
    pointer /= path.substr(at, dot - at);
    at = dot + 1;
  }
  return pointer;
}

// Where the file leaves out what the value stands in, that begins as its defaults.
void put(json& document, const json& normal, const json::json_pointer& pointer, const json& value) {
  json::json_pointer missing = pointer.parent_pointer();
  json::json_pointer outermost;
  while (!missing.empty() && !document.contains(missing)) {
    outermost = missing;
    missing = missing.parent_pointer();
  }
  if (!outermost.empty() && normal.contains(outermost)) document[outermost] = normal[outermost];
  document[pointer] = value;
}

}  // namespace

OverridableModel::OverridableModel(std::string file) : file_(std::move(file)) {
  const std::string text = load_json_text(file_);
  document_ = parse_json_text(text, file_);
  sha256_ = compute_sha256(text);
}

json OverridableModel::with_values(std::vector<ValueToSet> values) const {
  const Member* format = find_format(document_);
  json document = document_;
  std::sort(values.begin(), values.end(),
            [](const ValueToSet& a, const ValueToSet& b) { return a.path < b.path; });
  for (const auto& [path, value, place] : values) {
    if (format == nullptr) {
      throw Error(ErrorCode::bad_input, place,
                  fmt::format("'{}' is no model and no design's spec: only their values can be set",
                              file_));
    }
    try {
      if (value.is_structured()) {
        document[pointer_of(path)] = value;
      } else {
        const json normal = read_document(document, *format, "");
        put(document, normal, find_member(normal, *format, path).pointer, value);
      }
      read_document(document, *format, "");
    } catch (const Error& error) {
      throw Error(ErrorCode::bad_input, place,
                  (error.place().empty() ? "" : error.place() + ": ") + error.message());
    } catch (const json::exception&) {
      throw Error(ErrorCode::bad_input, place,
                  "names nothing of the model: keys are separated by '.', items of lists are "
                  "numbers from 0");
    }
  }
  const fs::path folder = fs::absolute(fs::path(file_)).parent_path();
  visit_files(document, [&](json& name) {
    name = (folder / name.get<std::string>()).lexically_normal().string();
  });
  return document;
}

json OverridableModel::value_of(const json& document, const std::string& path) const {
  const Member* format = find_format(document_);
  if (format == nullptr) return {};
  const json normal = read_document(document, *format, "");
  const json::json_pointer pointer = pointer_of(path);
  if (!normal.contains(pointer)) return {};
  const json& value = normal[pointer];
  if (value.is_structured()) return value;
  const FoundMember found = find_member(normal, *format, path);
  if (found.member.kind == ValueKind::time && value.is_string())
    return Rational::from_text(value.get<std::string>()).to_double();
  return value;
}

std::vector<fs::path> OverridableModel::named_files() const {
  std::vector<fs::path> files;
  json document = document_;
  const fs::path folder = fs::path(file_).parent_path();
  visit_files(document, [&](json& name) { files.push_back(folder / name.get<std::string>()); });
  return files;
}

std::map<std::string, std::string> OverridableModel::hash_named_files() const {
  std::map<std::string, std::string> hashes;
  json document = document_;
  const fs::path folder = fs::path(file_).parent_path();
  visit_files(document, [&](json& name) {
    const std::string given = name;
    hashes[given] = compute_sha256(read_text_file_if_any(folder / given));
  });
  return hashes;
}

}  // namespace gyrator
