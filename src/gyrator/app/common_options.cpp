#include "common_options.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/output_file.hpp"
#include "gyrator/plots/plot.hpp"
#include "gyrator/studies/result_figures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include <fmt/core.h>

#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

std::string& command_line() {
  static std::string text;
  return text;
}

// The library does not know which option a text came from: put its name in front.
template <class Function>
auto naming(const std::string& option, const Function& parse) {
  try {
    return parse();
  } catch (const Error& error) {
    throw Error(ErrorCode::bad_input, option, error.message());
  }
}

// Devices and pipes (/dev/null) may be given as often as one likes.
bool is_same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  for (const auto& path : {a, b}) {
    if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored)) return false;
  }
  if (fs::exists(a, ignored) && fs::exists(b, ignored)) return fs::equivalent(a, b, ignored);
  const auto whole = [&](const std::string& path) {
    return fs::weakly_canonical(fs::absolute(path), ignored);
  };
  return whole(a) == whole(b);
}

}  // namespace

void add_common_options(CLI::App& command, CommonOptions& options, const std::string& csv_help,
                        const std::string& example) {
  command.add_option("MODEL", options.model, "Model file (JSON)")->required()->check(not_empty());
  add_output_options(command, options, csv_help, example);
}

void add_output_options(CLI::App& command, CommonOptions& options, const std::string& csv_help,
                        const std::string& example) {
  command.add_flag("--json", options.json, "Print one JSON object and nothing else");
  const auto add_file = [&](const char* name, std::string& path, const std::string& help) {
    command.add_option(name, path, help)->type_name("FILE")->check(not_empty());
  };
  add_file("-o,--output", options.output, "Write the result as JSON, for `gyrator report`");
  add_file("--csv", options.csv, csv_help);
  add_file("--svg", options.svg, "Draw the result as SVG");
  add_file("--png", options.png, "Draw the result as PNG");
  command.add_flag("--quiet", options.quiet,
                   "No text and no progress, only files and the exit code");
  command.add_flag("--verbose", options.verbose, "More detail");
  command.footer("Example:\n  " + example);
}

void check_outputs(const CommonOptions& options) {
  check_outputs(options, {{"the model", options.model}});
}

void check_outputs(const CommonOptions& options, const std::vector<NamedFile>& inputs) {
  if (!options.svg.empty() && !options.svg.ends_with(".svg")) {
    throw Error(ErrorCode::bad_input, "--svg", options.svg + ": the name must end in .svg");
  }
  if (!options.png.empty() && !options.png.ends_with(".png")) {
    throw Error(ErrorCode::bad_input, "--png", options.png + ": the name must end in .png");
  }
  check_files(inputs, {{"--output", options.output},
                       {"--csv", options.csv},
                       {"--svg", options.svg},
                       {"--png", options.png}});
}

void check_files(const std::vector<NamedFile>& inputs, const std::vector<NamedFile>& outputs) {
  std::vector<NamedFile> taken = inputs;
  for (const auto& output : outputs) {
    if (output.path.empty()) continue;
    for (const auto& other : taken) {
      if (other.path.empty() || !is_same_file(output.path, other.path)) continue;
      throw Error(ErrorCode::bad_input, output.name,
                  fmt::format("'{}': would overwrite {}: give it a name of its own", output.path,
                              other.name));
    }
    taken.push_back(output);
  }
  for (const auto& output : outputs) {
    if (!output.path.empty()) check_writable(output.path);
  }
}

void deliver(const CommonOptions& options, nlohmann::json result, const std::string& text) {
  result["command_line"] = command_line();
  if (!options.svg.empty()) render_figure(result_figure(result), options.svg);
  if (!options.png.empty()) render_figure(result_figure(result), options.png);
  // A file's name on the command line need not be UTF-8, which JSON is.
  const auto dump = [&](int indent) {
    return result.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
  };
  if (!options.output.empty()) write_text_file(options.output, dump(1) + "\n");
  if (options.json) {
    fmt::print("{}\n", dump(-1));
  } else if (!options.quiet) {
    fmt::print("{}", text);
  }
}

void print_note(const std::string& text) noexcept {
  std::fwrite(text.data(), 1, text.size(), stderr);
}

std::string describe_nominal_values(const Model& model, const char* judged) {
  const std::size_t parts = model.parts.tolerances.size();
  if (parts == 0) return {};
  return fmt::format(
      "\n{} at the nominal values of {} with a tolerance: `gyrator tolerance` varies {}.\n", judged,
      describe_count(parts, "part"), parts == 1 ? "it" : "them");
}

std::string describe_frequency(double hz) {
  if (hz < 1e-3) return "-> 0 Hz";
  return format_quantity(std::strtod(fmt::format("{:.4g}", hz).c_str(), nullptr),
                         dimension::frequency);
}

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> items;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    items.emplace_back(trim(std::string_view(text).substr(at, comma - at)));
    at = comma + 1;
  }
  return items;
}

std::vector<std::string> parse_names(const std::string& option, const std::string& text) {
  std::vector<std::string> names = split_list(text);
  if (const auto twice = find_repeated(names))
    throw Error(ErrorCode::bad_input, option, *twice + ": is there twice: once is enough");
  return names;
}

std::vector<double> parse_list(const std::string& option, const std::string& text,
                               const Unit& unit) {
  std::vector<double> values;
  for (const std::string& item : split_list(text)) {
    const double value = parse_option(option, item, unit);
    if (std::find(values.begin(), values.end(), value) != values.end())
      throw Error(ErrorCode::bad_input, option,
                  fmt::format("{}: is there twice: once is enough", trim(item)));
    values.push_back(value);
  }
  return values;
}

double parse_option(const std::string& option, const std::string& text, const Unit& unit) {
  return naming(option, [&] { return parse_value(text, unit); });
}

Rational parse_option_time(const std::string& option, const std::string& text) {
  const Rational time = naming(option, [&] { return parse_time(text); });
  if (time <= Rational(0)) {
    const auto number = find_decimal(text);
    const bool is_bare = number && number->length == text.size();
    throw Error(ErrorCode::bad_input, option,
                fmt::format("{}{}: must be longer than 0 s", text, is_bare ? " s" : ""));
  }
  return time;
}

std::string quote_word(const std::string& word) {
  const bool plain = word.find_first_of(" '\"$&|;<>()*?#") == std::string::npos && !word.empty();
  return plain ? word : "'" + word + "'";
}

void remember_command_line(int argc, char** argv) {
  std::string& text = command_line();
  text = "gyrator";
  for (int i = 1; i < argc; ++i) {
    text += " " + quote_word(argv[i]);
  }
}

}  // namespace gyrator::app
