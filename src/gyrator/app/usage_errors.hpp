#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace gyrator::app {

/// What is wrong with the command line, in the program's own words: the option or word in question,
/// what is allowed, the nearest known name, and where the help is.
std::string describe_usage_error(const CLI::App& app, const CLI::ParseError& error);

// Checks for an option's text, with a message that says what is expected.
CLI::Validator not_empty();
CLI::Validator whole_number_between(long low, long high);
CLI::Validator number_between(double low, double high);

}  // namespace gyrator::app
