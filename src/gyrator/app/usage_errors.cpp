#include "usage_errors.hpp"

#include "gyrator/core/text.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/core.h>

namespace gyrator::app {
namespace {

std::vector<std::string> list_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

std::vector<std::string> list_options(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const auto& name : option->get_snames()) names.push_back("-" + name);
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

bool is_option(const std::string& word) {
  return word.size() > 1 && word.front() == '-';
}

std::string describe_unknown_option(const CLI::App& command, const std::string& word) {
  return describe_unknown_name("option", word.substr(0, word.find('=')), list_options(command));
}

// "study run", of the program itself nothing.
std::string name_command(const CLI::App& command) {
  if (command.get_parent() == nullptr) return {};
  const std::string outer = name_command(*command.get_parent());
  return outer.empty() ? command.get_name() : outer + " " + command.get_name();
}

std::string describe_missing_command(const CLI::App& app, const std::vector<std::string>& words) {
  const std::string name = name_command(app);
  const std::string help =
      fmt::format(" (`gyrator {}--help` describes the commands)", name.empty() ? "" : name + " ");
  if (words.empty()) return "a command is expected, one of " + join(list_commands(app)) + help;
  if (is_option(words.front())) return describe_unknown_option(app, words.front()) + help;
  return describe_unknown_name("command", words.front(), list_commands(app)) + help;
}

// CLI11's own errors know no grammar: the option's name and, for us, a sentence.
std::string describe_parse_error(const CLI::ParseError& error) {
  std::string what = error.what();
  const std::string name = what.substr(0, what.find(':'));
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    if (what.ends_with("missing")) return name + ": a value must follow";
    if (what.find("At Most") != std::string::npos) return name + ": may be given only once";
  }
  constexpr std::string_view excludes = " excludes ";
  if (const auto at = what.find(excludes); at != std::string::npos) {
    what.replace(at, excludes.size(), " cannot be given together with ");
  }
  return what;
}

template <class Number>
std::optional<Number> find_number(const std::string& text) {
  Number number{};
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, number);
  if (result.ec != std::errc{} || result.ptr != end) return std::nullopt;
  return number;
}

template <class Number>
CLI::Validator between(Number low, Number high, const std::string& kind) {
  const std::string expected = fmt::format("{} from {} to {}", kind, low, high);
  const auto check = [=](const std::string& text) {
    const auto number = find_number<Number>(text);
    if (number && *number >= low && *number <= high) return std::string();
    return fmt::format("'{}': {} is expected", text, expected);
  };
  return {check, fmt::format("{} to {}", low, high), ""};
}

}  // namespace

std::string describe_usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const auto chosen = app.get_subcommands();
  const auto words = app.remaining();
  if (chosen.empty()) return describe_missing_command(app, words);
  const CLI::App& command = *chosen.front();
  // Of `study run` the inner one, if it was named.
  const bool has_inner = !list_commands(command).empty();
  if (has_inner && !command.get_subcommands().empty()) return describe_usage_error(command, error);
  const std::string name = name_command(command);
  const std::string help = fmt::format(" (`gyrator {} --help` describes it)", name);
  if (has_inner) return name + ": " + describe_missing_command(command, command.remaining());
  if (!words.empty()) {
    return fmt::format("'{}' stands before the command: write gyrator {} {}{}", words.front(), name,
                       words.front(), help);
  }
  const auto left = command.remaining();
  const auto option = std::find_if(left.begin(), left.end(), is_option);
  if (option != left.end()) {
    return fmt::format("{}: {}{}", name, describe_unknown_option(command, *option), help);
  }
  if (!left.empty())
    return fmt::format("{}: '{}' is one argument too many{}", name, left.front(), help);
  return fmt::format("{}: {}{}", name, describe_parse_error(error), help);
}

CLI::Validator not_empty() {
  return {[](const std::string& text) {
            return text.empty() ? std::string("the value is empty") : std::string();
          },
          "", ""};
}

CLI::Validator whole_number_between(long low, long high) {
  return between(low, high, "a whole number");
}

CLI::Validator number_between(double low, double high) {
  return between(low, high, "a number");
}

}  // namespace gyrator::app
