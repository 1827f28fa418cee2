#pragma once

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

/// The bytes of an HDF5 file: one dataset of one dimension per column, its attributes and the
/// file's on the root group, in order of creation; texts in UTF-8 of any length. It holds no times
/// and nothing of the machine: the same columns give the same bytes.
/// Throws numerical where the HDF5 library gives up (memory).
std::string build_hdf5(const ColumnFile& file);

/// What build_hdf5 wrote; datasets and attributes of other kinds are passed over. Throws bad_input
/// for a file that is missing, cannot be read, or is no HDF5 file.
ColumnFile read_hdf5(const std::string& path);

}  // namespace gyrator
