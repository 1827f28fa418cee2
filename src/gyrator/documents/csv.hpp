#pragma once

#include <string>
#include <vector>

namespace gyrator {

/// Writes columns of numbers as comma-separated values: one header line, then one row per index.
///
/// Numbers as %.17g, so that reading them back gives the same bits; "nan", "inf", "-inf" for the
/// others. Column names are quoted as RFC 4180 asks (comma, quote, line break); lines end in LF,
/// which every reader takes and Unix tools want. The file appears whole or not at all.
/// Throws bad_input where the numbers of names and columns, or the columns' lengths, differ.
void write_csv(const std::string& path, const std::vector<std::string>& columns,
               const std::vector<std::vector<double>>& columns_of_data);

/// Columns of numbers read from a file.
struct CsvColumns {
  std::vector<std::vector<double>> columns;  ///< in the order asked for, of equal length
  std::vector<long> lines;                   ///< of each row in the file, for messages
};

/// Reads the named columns of a file of comma-separated values whose first line has their names.
///
/// Quotes as of RFC 4180 in one line each; LF or CRLF; a byte-order mark and blank lines are
/// passed over. Columns that are not asked for may hold anything.
/// Throws bad_input for a file that cannot be read or has no row, an unknown column (with those
/// there are), one whose name stands there twice, a row with more fields than the header, and, with
/// file, line and column's name, for a field that is missing or is no finite number: a recording
/// with gaps is no recording.
CsvColumns read_csv(const std::string& path, const std::vector<std::string>& names);

}  // namespace gyrator
