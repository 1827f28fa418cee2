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

}  // namespace gyrator
