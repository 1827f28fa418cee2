#pragma once

#include "gyrator/core/quantity.hpp"
#include "gyrator/core/rational.hpp"
#include "gyrator/studies/model_file.hpp"

#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace gyrator::app {

/// What every command that computes something offers.
struct CommonOptions {
  std::string model;
  bool json = false;
  std::string csv, svg, png, output;
  bool quiet = false;
  bool verbose = false;
};

/// Adds MODEL and the common options. `csv_help` says what the CSV file holds, `example` ends
/// --help.
void add_common_options(CLI::App& command, CommonOptions& options, const std::string& csv_help,
                        const std::string& example);

/// The same without MODEL, for a command that takes other inputs.
void add_output_options(CLI::App& command, CommonOptions& options, const std::string& csv_help,
                        const std::string& example);

struct NamedFile {
  std::string name;  ///< "--csv", "the model"
  std::string path;  ///< empty where it was not asked for
};

/// Fails before long work where an output could not be written as asked, or would overwrite the
/// model or another output.
void check_outputs(const CommonOptions& options);
void check_outputs(const CommonOptions& options, const std::vector<NamedFile>& inputs);
void check_files(const std::vector<NamedFile>& inputs, const std::vector<NamedFile>& outputs);

/// Plots, the result file, and on stdout `text` or, with --json, the result.
void deliver(const CommonOptions& options, nlohmann::json result, const std::string& text);

/// A remark or progress on stderr; where nobody can read that any more, the work goes on without.
void print_note(const std::string& text) noexcept;

/// A line that says how many quantities of the model have a tolerance, which this command leaves
/// out; empty where none has. `judged`: "Judged", "Simulated".
std::string describe_nominal_values(const Model& model, const char* judged = "Computed");

/// A frequency with four digits for tables and sentences. Far below the slowest pole it stands for
/// the limit at zero.
std::string describe_frequency(double hz);

/// The items between commas, without the blanks around them.
std::vector<std::string> split_list(const std::string& text);

/// The same as names; refuses one that is there twice, naming the option.
std::vector<std::string> parse_names(const std::string& option, const std::string& text);

/// "1, 10, 2 kHz" as numbers in the expected unit; bare numbers are SI, none twice. Errors name the
/// option.
std::vector<double> parse_list(const std::string& option, const std::string& text,
                               const Unit& unit);
double parse_option(const std::string& option, const std::string& text, const Unit& unit);
Rational parse_option_time(const std::string& option, const std::string& text);

/// A word as a shell takes it, in quotes where it must be.
std::string quote_word(const std::string& word);

/// The command line as typed, kept in every result.
void remember_command_line(int argc, char** argv);

}  // namespace gyrator::app
