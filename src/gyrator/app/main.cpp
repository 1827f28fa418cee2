// gyrator: argv in, exit code out. The commands are one file each beside this one.

#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/studies/parallel.hpp"
#include "gyrator/version.hpp"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <system_error>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace {

constexpr int usage_error = 2;
constexpr int internal_error = 3;

int run(int argc, char** argv) {
  int exit_code = 0;
  CLI::App app(
      "gyrator: co-simulation, passivity and analog damping of haptic displays and motor drives");
  app.set_version_flag("--version", fmt::format("gyrator {}", gyrator::version));
  app.require_subcommand(1);
  app.footer(
      "A model file describes motor, amplifier, damping circuit, mechanics and controller.\n"
      "Example:\n  gyrator passivity examples/rc_display.json\n\n"
      "Exit codes: 0 done, 1 the answer is no, 2 bad input, 3 numerical failure,\n4 device or "
      "communication failure, 130 interrupted (Ctrl-C, SIGTERM, "
      "SIGHUP).");
  gyrator::app::add_impedance_command(app, exit_code);
  gyrator::app::add_passivity_command(app, exit_code);
  gyrator::app::add_verify_certificate_command(app, exit_code);
  gyrator::app::add_zwidth_command(app, exit_code);
  gyrator::app::add_compare_command(app, exit_code);
  gyrator::app::add_simulate_command(app, exit_code);
  gyrator::app::add_stability_map_command(app, exit_code);
  gyrator::app::add_tolerance_command(app, exit_code);
  gyrator::app::add_study_command(app, exit_code);
  gyrator::app::add_two_port_command(app, exit_code);
  gyrator::app::add_environment_command(app, exit_code);
  gyrator::app::add_workspace_command(app, exit_code);
  gyrator::app::add_spice_command(app, exit_code);
  gyrator::app::add_report_command(app, exit_code);
  gyrator::app::add_schematic_command(app, exit_code);
  gyrator::app::add_schema_command(app, exit_code);
  gyrator::app::add_design_command(app, exit_code);
  gyrator::app::add_twin_command(app, exit_code);
  gyrator::app::add_identify_command(app, exit_code);
  gyrator::app::add_tune_command(app, exit_code);
  gyrator::app::add_backup_command(app, exit_code);
  gyrator::app::add_diff_command(app, exit_code);
  gyrator::app::add_restore_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::fprintf(stderr, "gyrator: %s\n", gyrator::app::describe_usage_error(app, error).c_str());
    return usage_error;
  }
  return exit_code;
}

// A full disk may show only when the last of stdout is written.
int finish_stdout(int exit_code) {
  errno = 0;
  const bool failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
  if (!failed) return exit_code;
  std::fprintf(stderr, "gyrator: stdout: cannot be written: %s\n",
               std::strerror(errno != 0 ? errno : EIO));
  return usage_error;
}

}  // namespace

int main(int argc, char** argv) {
  gyrator::install_interrupt_handler();
  // A reader that goes away must not end what is on its way: a motor may be turning.
  std::signal(SIGPIPE, SIG_IGN);
  gyrator::app::remember_command_line(argc, argv);
  const gyrator::ThreadLimit limit(gyrator::read_threads_variable());
  try {
    return finish_stdout(run(argc, argv));
  } catch (const gyrator::Error& error) {
    std::fprintf(stderr, "gyrator: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::system_error& error) {  // what printing to a full stdout throws
    std::fprintf(stderr, "gyrator: stdout: cannot be written: %s\n",
                 error.code().message().c_str());
    return usage_error;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gyrator: internal error: %s\n", error.what());
    return internal_error;
  }
}
