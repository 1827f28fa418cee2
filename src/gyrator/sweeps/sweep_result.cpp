#include "gyrator/sweeps/sweep_result.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/plots/pretty_text.hpp"
#include "gyrator/sweeps/sweep_journal.hpp"
#include "gyrator/version.hpp"

#include <algorithm>
#include <numeric>

#include <fmt/core.h>
#include <fmt/format.h>

namespace gyrator {
namespace {

using nlohmann::json;

constexpr const char* sweep_schema = "gyrator/sweep/1";

std::string dump(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

void add_attributes(ColumnFile& file, const SweepPlan& plan, const std::string& command_line) {
  const SweepStudy& study = plan.study();
  file.attributes = {{"schema", sweep_schema},
                     {"program", fmt::format("gyrator {}", version)},
                     {"command_line", command_line},
                     {"analysis", study.analysis},
                     {"sampling", std::string(name_of(study.sampling))},
                     {"seed", static_cast<std::int64_t>(study.seed)},
                     {"study", dump(describe_study(study))},
                     {"model_name", plan.model_name()},
                     {"model_sha256", plan.model_sha256()},
                     {"model", study.model_text}};
}

Column make_varied_column(const SweepPlan& plan, std::size_t index,
                          const std::vector<std::vector<SweepValue>>& rows) {
  const Variation& variation = plan.variations()[index];
  Column column{variation.path(), {{"unit", variation.unit()}, {"role", "varied"}}, {}};
  if (variation.is_number()) {
    std::vector<double> numbers;
    for (const auto& row : rows) numbers.push_back(row[index].number);
    column.values = std::move(numbers);
  } else {
    std::vector<std::string> texts;
    for (const auto& row : rows) texts.push_back(row[index].text);
    column.values = std::move(texts);
  }
  return column;
}

void add_index(ColumnFile& file, const SweepStore& store, const std::vector<std::size_t>& points) {
  std::vector<std::int32_t> status;
  std::vector<std::string> reasons;
  for (const std::size_t point : points) {
    status.push_back(static_cast<std::int32_t>(*store.status(point)));
    reasons.push_back(store.reason(point));
  }
  file.columns.push_back(
      {"status",
       {{"unit", "1"}, {"role", "index"}, {"meaning", "0: ok, 1: failed, 2: timed_out"}},
       std::move(status)});
  file.columns.push_back({"reason",
                          {{"unit", ""}, {"role", "index"}, {"meaning", "why the point failed"}},
                          std::move(reasons)});
}

// One field of a row as text; numbers so that they read back as the same bits.
std::string format_field(const Column& column, std::size_t row, const char* number_format) {
  if (const auto* numbers = std::get_if<std::vector<double>>(&column.values))
    return fmt::format(fmt::runtime(number_format), (*numbers)[row]);
  if (const auto* codes = std::get_if<std::vector<std::int32_t>>(&column.values))
    return fmt::format("{}", (*codes)[row]);
  return std::get<std::vector<std::string>>(column.values)[row];
}

std::string quote(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

const std::vector<std::int32_t>& status_of(const SweepTable& table) {
  const Column* status = table.file.find("status");
  const auto* codes =
      status == nullptr ? nullptr : std::get_if<std::vector<std::int32_t>>(&status->values);
  if (codes == nullptr) throw Error(ErrorCode::bad_input, "status", "the column is missing");
  return *codes;
}

std::string name_of_code(std::int32_t code) {
  if (code < 0 || code > static_cast<std::int32_t>(PointStatus::timed_out)) return "unknown";
  return std::string(name_of(static_cast<PointStatus>(code)));
}

// "controller.stiffness [N.m/rad]"
std::string title_of(const Column& column) {
  const std::string unit = column.attribute("unit");
  return unit.empty() || unit == "1" ? column.name : fmt::format("{} [{}]", column.name, unit);
}

}  // namespace

SweepTable make_sweep_table(const SweepPlan& plan, const SweepStore& store,
                            const std::string& command_line) {
  SweepTable table;
  table.size = store.size();
  std::vector<std::vector<SweepValue>> values;
  for (std::size_t i = 0; i < store.size(); ++i) {
    if (!store.status(i)) continue;
    table.points.push_back(i);
    values.push_back(plan.values_at(i));
  }
  add_attributes(table.file, plan, command_line);
  for (std::size_t p = 0; p < plan.variations().size(); ++p)
    table.file.columns.push_back(make_varied_column(plan, p, values));
  for (std::size_t k = 0; k < plan.outputs().size(); ++k) {
    const SweepOutput& output = plan.outputs()[k];
    std::vector<double> numbers;
    for (const std::size_t point : table.points) numbers.push_back(store.output(point, k));
    table.file.columns.push_back(
        {output.name,
         {{"unit", output.unit}, {"role", "output"}, {"meaning", output.meaning}},
         std::move(numbers)});
  }
  add_index(table.file, store, table.points);
  return table;
}

void write_sweep_file(const std::string& path, const SweepPlan& plan, const SweepStore& store,
                      const std::string& command_line) {
  write_hdf5(path, make_sweep_table(plan, store, command_line).file, Durability::before_rename);
}

SweepTable read_sweep(const std::string& path) {
  if (is_journal(path)) {
    const JournalContent content = read_journal(path);
    return make_sweep_table(content.plan, content.store, "");
  }
  SweepTable table;
  table.file = read_hdf5(path);
  if (table.file.attribute("schema") != sweep_schema || table.file.columns.empty())
    throw Error(ErrorCode::bad_input, path, "is no result of a sweep, nor its journal");
  table.size = table.file.columns.front().size();
  for (const Column& column : table.file.columns) {
    if (column.size() == table.size) continue;
    throw Error(ErrorCode::bad_input, path,
                fmt::format("the column '{}' has another length than the others", column.name));
  }
  table.points.resize(table.size);
  std::iota(table.points.begin(), table.points.end(), std::size_t{0});
  return table;
}

SweepCounts count_rows(const SweepTable& table) {
  SweepCounts counts;
  counts.points = table.size;
  for (const std::int32_t code : status_of(table)) {
    if (code == static_cast<std::int32_t>(PointStatus::ok)) ++counts.ok;
    if (code == static_cast<std::int32_t>(PointStatus::failed)) ++counts.failed;
    if (code == static_cast<std::int32_t>(PointStatus::timed_out)) ++counts.timed_out;
  }
  return counts;
}

void write_sweep_csv(const std::string& path, const SweepTable& table) {
  OutputFile file(path);
  std::string line = "point";
  for (const Column& column : table.file.columns) line += "," + quote(title_of(column));
  file.stream() << line << "\n";
  for (std::size_t row = 0; row < table.points.size(); ++row) {
    if (row % 10000 == 0) throw_if_interrupted(path);
    line = std::to_string(table.points[row]);
    for (const Column& column : table.file.columns)
      line += "," + quote(format_field(column, row, "{:.17g}"));
    file.stream() << line << "\n";
  }
  file.commit();
}

std::string describe_sweep(const SweepTable& table, std::size_t most_rows) {
  const std::vector<std::int32_t>& status = status_of(table);
  const std::size_t rows = table.points.size();
  const std::size_t stride = std::max<std::size_t>(1, (rows + most_rows - 1) / most_rows);
  std::vector<const Column*> shown;
  std::vector<std::size_t> widths;
  std::string text = fmt::format("{:>8}", "point");
  for (const Column& column : table.file.columns) {
    if (column.attribute("role") == "index") continue;
    shown.push_back(&column);
    const std::string title = plain_text(title_of(column));
    widths.push_back(std::max<std::size_t>(12, title.size()));
    text += fmt::format("  {:>{}}", title, widths.back());
  }
  text += "  status\n";
  const Column* reason = table.file.find("reason");
  for (std::size_t row = 0; row < rows; row += stride) {
    text += fmt::format("{:>8}", table.points[row]);
    for (std::size_t c = 0; c < shown.size(); ++c)
      text +=
          fmt::format("  {:>{}}", plain_text(format_field(*shown[c], row, "{:.6g}")), widths[c]);
    text += "  " + name_of_code(status[row]);
    const std::string why = reason == nullptr ? "" : format_field(*reason, row, "{}");
    text += (why.empty() ? "" : ": " + plain_text(why)) + "\n";
  }
  return text;
}

}  // namespace gyrator
