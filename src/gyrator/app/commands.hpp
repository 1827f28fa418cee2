#pragma once

#include <CLI/CLI.hpp>

namespace gyrator::app {

// One function per command: adds it to the parser. When the command was given, its callback does
// the work and sets the exit code (0 done, 1 the answer is no).
void add_impedance_command(CLI::App& app, int& exit_code);
void add_passivity_command(CLI::App& app, int& exit_code);
void add_verify_certificate_command(CLI::App& app, int& exit_code);
void add_zwidth_command(CLI::App& app, int& exit_code);
void add_compare_command(CLI::App& app, int& exit_code);
void add_simulate_command(CLI::App& app, int& exit_code);
void add_spice_command(CLI::App& app, int& exit_code);
void add_report_command(CLI::App& app, int& exit_code);
void add_schema_command(CLI::App& app, int& exit_code);
void add_stability_map_command(CLI::App& app, int& exit_code);
void add_tolerance_command(CLI::App& app, int& exit_code);
void add_two_port_command(CLI::App& app, int& exit_code);
void add_study_command(CLI::App& app, int& exit_code);
void add_schematic_command(CLI::App& app, int& exit_code);
void add_environment_command(CLI::App& app, int& exit_code);
void add_workspace_command(CLI::App& app, int& exit_code);
void add_design_command(CLI::App& app, int& exit_code);
void add_twin_command(CLI::App& app, int& exit_code);
void add_identify_command(CLI::App& app, int& exit_code);
void add_tune_command(CLI::App& app, int& exit_code);
void add_backup_command(CLI::App& app, int& exit_code);
void add_diff_command(CLI::App& app, int& exit_code);
void add_restore_command(CLI::App& app, int& exit_code);

}  // namespace gyrator::app
