#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// A value to be set in a model.
struct ValueToSet {
  std::string path;  ///< "damping.0.capacitance"
  nlohmann::json value;
  std::string place;  ///< for messages: "study.json: /runs/0/set/damping.0.capacitance"
};

/// A model (or a design's spec) as written, to be run with other values.
class OverridableModel {
 public:
  /// `file` is as it is opened. Throws bad_input for a file that cannot be read.
  explicit OverridableModel(std::string file);

  /// The document with these values, as the user would have written it; files that it names are
  /// absolute, so that it can stand anywhere. Paths are taken in their order, "controller" before
  /// "controller.stiffness". An object or a list replaces what is there; a single value must be a
  /// key of the format. Throws bad_input, at the value's place, for a path or a value that the
  /// format does not allow, and for a file that is neither model nor spec.
  nlohmann::json with_values(std::vector<ValueToSet> values) const;

  /// The value of a path in SI units where it is a quantity or a time, else as it stands.
  nlohmann::json value_of(const nlohmann::json& document, const std::string& path) const;

  const std::string& sha256() const { return sha256_; }
  /// The netlists, recordings and models that it names, as they are opened.
  std::vector<std::filesystem::path> named_files() const;
  /// SHA-256 of the files that it names, by their names there; of one that is missing, that of
  /// nothing. Throws bad_input for a folder.
  std::map<std::string, std::string> hash_named_files() const;

 private:
  std::string file_;
  nlohmann::json document_;
  std::string sha256_;
};

}  // namespace gyrator
