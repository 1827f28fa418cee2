#pragma once

#include "gyrator/circuits/spice_lines.hpp"
#include "gyrator/circuits/spice_scope.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// A `.model` line.
struct SpiceModel {
  std::string name;  ///< as written
  std::string type;  ///< lower case: "d", "npn"
  std::string place;
  SpiceCard card;  ///< its name and what is assigned; of diodes only
};

/// A subcircuit as its file states it, or (without pins) what stands outside of any.
struct SpiceDefinition {
  std::string name;  ///< as written
  std::string place;
  std::vector<std::string> pins;           ///< lower case
  std::vector<SpiceParameter> defaults;    ///< of the `.subckt` line; an instance may override them
  std::vector<SpiceParameter> parameters;  ///< of its `.param` lines
  std::vector<SpiceCard> elements;
  std::vector<SpiceModel> models;
  std::vector<SpiceDefinition> definitions;  ///< known inside of this one only
  bool built_in = false;

  /// The subcircuit of this name (in any case) that is defined here, or null.
  const SpiceDefinition* find_definition(std::string_view wanted) const;
  /// The same for its models.
  const SpiceModel* find_model(std::string_view wanted) const;
};

/// A file with all that it includes.
struct SpiceDeck {
  SpiceDefinition top;
  /// `.lib` files that do not exist, each as "file:12: standard.dio".
  std::vector<std::string> missing_libraries;
};

/// Reads a SPICE file and what it includes (paths relative to the including file).
///
/// Elements are kept as words: what they mean is asked when a subcircuit is used. Throws bad_input,
/// with file and line, for a file that cannot be read, a cycle of includes, a `.subckt` without
/// `.ends` and a control line that changes the circuit in a way that is not supported.
SpiceDeck read_spice_deck(const std::filesystem::path& path);

/// The same for a text; `file` names it and is where included paths begin.
SpiceDeck parse_spice_deck(std::string_view text, const std::filesystem::path& file);

/// The file and all that it includes, each once, in the order in which they are read; named as the
/// reader finds them, from the folder of the file that includes them. Throws as read_spice_deck
/// does for files that cannot be read.
std::vector<std::filesystem::path> find_spice_files(const std::filesystem::path& path);

/// The subcircuits that are there without a file: `opamp` and `ideal_opamp` (docs/netlist.md).
const SpiceDefinition& built_in_spice_library();

}  // namespace gyrator
