// gyrator: argv in, exit code out. The commands are one file each beside this one.

#include <cstdio>
#include <exception>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/version.hpp"

namespace {

constexpr int usage_error = 2;
constexpr int internal_error = 3;

int run(int argc, char** argv) {
  int exit_code = 0;
  CLI::App app("gyrator: co-simulation, passivity and analog damping of haptic displays and motor drives");
  app.set_version_flag("--version", fmt::format("gyrator {}", gyrator::version));
  app.require_subcommand(1);
  app.footer("A model file describes motor, amplifier, damping circuit, mechanics and controller.\n"
             "Example:\n  gyrator passivity examples/rc_display.json\n\n"
             "Exit codes: 0 done, 1 the answer is no, 2 bad input, 3 numerical failure, 130 interrupted.");
  gyrator::app::add_impedance_command(app, exit_code);
  gyrator::app::add_passivity_command(app, exit_code);
  gyrator::app::add_zwidth_command(app, exit_code);
  gyrator::app::add_simulate_command(app, exit_code);
  gyrator::app::add_report_command(app, exit_code);
  gyrator::app::add_schema_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    app.exit(error);
    return usage_error;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  gyrator::install_interrupt_handler();
  gyrator::app::remember_command_line(argc, argv);
  try {
    return run(argc, argv);
  } catch (const gyrator::Error& error) {
    std::fprintf(stderr, "gyrator: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gyrator: internal error: %s\n", error.what());
    return internal_error;
  }
}
