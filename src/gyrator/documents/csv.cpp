#include "gyrator/documents/csv.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/documents/output_file.hpp"

#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace gyrator {
namespace {

std::string quoted(const std::string& field) {
  if (field.find_first_of(",\"\r\n") == std::string::npos) return field;
  std::string text = "\"";
  for (const char c : field) {
    if (c == '"') text += '"';
    text += c;
  }
  return text + '"';
}

void append_number(std::string& row, double value) {
  if (std::isnan(value)) {
    row += "nan";  // never "-nan", which some readers refuse
  } else {
    fmt::format_to(std::back_inserter(row), "{:.17g}", value);
  }
}

void check_shape(const std::string& path, const std::vector<std::string>& columns,
                 const std::vector<std::vector<double>>& data) {
  if (columns.size() != data.size())
    throw Error(ErrorCode::bad_input, path,
                fmt::format("{} column names for {} columns", columns.size(), data.size()));
  for (std::size_t i = 1; i < data.size(); ++i)
    if (data[i].size() != data[0].size())
      throw Error(ErrorCode::bad_input, path,
                  fmt::format(R"(column "{}" has {} rows, "{}" has {})", columns[i], data[i].size(),
                              columns[0], data[0].size()));
}

}  // namespace

void write_csv(const std::string& path, const std::vector<std::string>& columns,
               const std::vector<std::vector<double>>& columns_of_data) {
  check_shape(path, columns, columns_of_data);
  OutputFile file(path);
  std::string row;
  for (std::size_t i = 0; i < columns.size(); ++i) row += (i ? "," : "") + quoted(columns[i]);
  file.stream() << row << '\n';

  const std::size_t rows = columns_of_data.empty() ? 0 : columns_of_data.front().size();
  for (std::size_t k = 0; k < rows; ++k) {
    row.clear();
    for (const auto& column : columns_of_data) {
      if (&column != &columns_of_data.front()) row += ',';
      append_number(row, column[k]);
    }
    row += '\n';
    file.stream() << row;
    if (k % 10000 == 0) throw_if_interrupted(path);
  }
  file.commit();
}

}  // namespace gyrator
