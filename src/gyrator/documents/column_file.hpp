#pragma once

#include "gyrator/documents/output_file.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace gyrator {

/// A column of a column file, with what it is: "unit", "role".
struct Column {
  using Values =
      std::variant<std::vector<double>, std::vector<std::int32_t>, std::vector<std::string>>;

  std::string name;  ///< without '/'
  std::vector<std::pair<std::string, std::string>> attributes;
  Values values;

  std::size_t size() const;
  /// The text of an attribute; empty where there is none.
  std::string attribute(std::string_view key) const;
};

/// Columns with names and units, and what is said of all of them.
struct ColumnFile {
  using Attribute = std::variant<std::string, std::int64_t>;

  std::vector<std::pair<std::string, Attribute>> attributes;
  std::vector<Column> columns;

  const Column* find(std::string_view name) const;
  /// A text attribute of the file; empty where there is none.
  std::string attribute(std::string_view key) const;
};

/// Writes an HDF5 file, whole or not at all: one dataset of one dimension per column, its
/// attributes and the file's on the root group, in order of creation; texts in UTF-8 of any length.
/// It holds no times and nothing of the machine: the same columns give the same bytes. Throws
/// bad_input for a path that cannot be written, or is no ordinary file.
void write_hdf5(const std::string& path, const ColumnFile& file,
                Durability durability = Durability::as_the_system_likes);

/// What write_hdf5 wrote; datasets and attributes of other kinds are passed over. Throws bad_input
/// for a file that is missing, cannot be read, or is no HDF5 file.
ColumnFile read_hdf5(const std::string& path);

}  // namespace gyrator
