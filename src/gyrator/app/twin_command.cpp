#include "gyrator/amplifiers/device_profile.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/interrupt.hpp"
#include "gyrator/studies/motion_terms.hpp"
#include "gyrator/studies/twin_model.hpp"
#include "gyrator/twin/twin_server.hpp"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include <fmt/core.h>

#include "commands.hpp"
#include "common_options.hpp"
#include "usage_errors.hpp"

namespace gyrator::app {
namespace {

struct Options {
  std::string model, profile = "gyrator_twin", listen, rtu;
  int unit = 0, baud = 0;
  std::string turnaround = "1 ms", time_scale = "real", misbehave;
  std::string command_noise = "0.1 mA", current_noise = "1 mA", voltage_noise = "5 mV";
  std::string velocity_noise = "0.02", position_noise;
  std::string current_step = "0.5 mA", voltage_step = "2 mV";
  std::string winding_rise, ambient, velocity_limit, seed;
  bool allow_remote = false, quiet = false;
};

// A signal handler can reach nothing but a static.
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
std::atomic<bool> terminated{false};

extern "C" void note_termination(int) {
  terminated.store(true);
}

void end_cleanly_when_terminated() {
  struct sigaction action {};
  action.sa_handler = note_termination;
  sigemptyset(&action.sa_mask);
  sigaction(SIGTERM, &action, nullptr);
}

TwinDevice make_device(const Options& options, const Model& model) {
  TwinDevice twin = make_twin_device(model);
  const auto set = [](double& value, const char* option, const std::string& text,
                      const Unit& unit) {
    if (!text.empty()) value = parse_option(option, text, unit);
  };
  const MotionUnits& units = units_of(model.device.motion);
  set(twin.noise.command, "--command-noise", options.command_noise, dimension::current);
  set(twin.noise.current, "--current-noise", options.current_noise, dimension::current);
  set(twin.noise.voltage, "--voltage-noise", options.voltage_noise, dimension::voltage);
  set(twin.noise.velocity, "--velocity-noise", options.velocity_noise, units.velocity);
  set(twin.noise.position, "--position-noise", options.position_noise, units.position);
  set(twin.current_step, "--current-step", options.current_step, dimension::current);
  set(twin.voltage_step, "--voltage-step", options.voltage_step, dimension::voltage);
  set(twin.winding_rise, "--winding-rise", options.winding_rise, dimension::temperature);
  set(twin.ambient, "--ambient", options.ambient, dimension::temperature);
  set(twin.velocity_limit, "--velocity-limit", options.velocity_limit, units.velocity);
  if (!options.seed.empty()) {
    const double seed = parse_option("--seed", options.seed, dimension::none);
    twin.seed = static_cast<std::uint64_t>(seed);
    if (!(seed >= 0) || static_cast<double>(twin.seed) != seed)
      throw Error(ErrorCode::bad_input, "--seed", options.seed + ": must be a whole number");
  }
  try {
    check_twin_device(twin);
  } catch (const Error& error) {
    throw Error(error.code(), model.file + ": /" + error.place(), error.message());
  }
  return twin;
}

std::optional<double> parse_pace(const std::string& text) {
  if (text == "max") return std::nullopt;
  if (text == "real") return 1.0;
  const double pace = parse_option("--time-scale", text, dimension::none);
  if (pace >= 0.01 && pace <= 50) return pace;
  throw Error(ErrorCode::bad_input, "--time-scale",
              fmt::format("{}: must be real, max, or a number from 0.01 to 50", text));
}

TcpAddress parse_listen(const std::string& text) {
  try {
    const std::string whole = text.find("://") == std::string::npos ? "tcp://" + text : text;
    // Port 0, any that is free, is no address to connect to.
    constexpr std::string_view any = ":0";
    const bool is_any = whole.size() > any.size() && whole.ends_with(any);
    const LinkAddress address =
        parse_link_address(is_any ? whole.substr(0, whole.size() - any.size()) : whole);
    TcpAddress tcp = std::get<TcpAddress>(address);
    if (is_any) tcp.port = 0;
    return tcp;
  } catch (const std::bad_variant_access&) {
    throw Error(ErrorCode::bad_input, "--listen", text + ": HOST:PORT is expected; see --rtu");
  } catch (const Error& error) {
    throw Error(ErrorCode::bad_input, "--listen", error.message());
  }
}

void open_lines(const Options& options, ModbusServer& server, const SerialAddress& wire) {
  if (options.rtu.empty() || !options.listen.empty()) {
    TcpAddress address = parse_listen(options.listen.empty() ? "127.0.0.1:1502" : options.listen);
    address.port = server.listen(address.host, address.port);
    fmt::print("listening on {}\n", describe(LinkAddress(address)));
  }
  if (!options.rtu.empty()) {
    SerialAddress line = wire;
    line.device = options.rtu;
    (void)server.open_pseudo_terminal(options.rtu, line);
    fmt::print("listening on {}\n", describe(LinkAddress(line)));
  }
  std::fflush(stdout);  // whoever started this waits for the address
}

void run_twin(const Options& options) {
  const Model model = load_model(options.model);
  const TwinDevice twin = make_device(options, model);
  const DeviceProfile profile = load_device_profile(options.profile);
  const TwinMoods moods =
      options.misbehave.empty() ? TwinMoods{} : parse_twin_moods(options.misbehave);
  TwinTiming timing;
  timing.pace = parse_pace(options.time_scale);
  timing.turnaround = parse_option("--turnaround", options.turnaround, dimension::time);
  if (!(timing.turnaround >= 0 && timing.turnaround <= 10))
    throw Error(ErrorCode::bad_input, "--turnaround",
                options.turnaround + ": must be from 0 to 10 s");
  SerialAddress wire;
  wire.baud = options.baud > 0 ? options.baud : 115200;
  // Over TCP there is no wire to wait for, unless one is asked for.
  if (!options.rtu.empty() || options.baud > 0) timing.wire = wire;

  SimulatedAmplifier amplifier(twin);
  TwinBank bank(amplifier, profile, {timing.pace, moods.stuck});
  ServerOptions server_options;
  server_options.unit = options.unit > 0 ? options.unit : profile.link.unit;
  server_options.loopback_only = !options.allow_remote;
  ModbusServer server(bank, server_options, make_twin_hooks(bank, timing, moods, twin.seed));
  end_cleanly_when_terminated();
  open_lines(options, server, wire);
  if (!options.quiet) {
    print_note(fmt::format("{} with the profile {}, unit {}; Ctrl-C ends it\n", model.name,
                           profile.name, server_options.unit));
  }
  constexpr double look_around = 0.05;  // [s]
  while (!terminated.load() && !interrupt_requested()) {
    if (server.poll(look_around)) break;
    bank.keep_pace();
  }
  acknowledge_interrupt();
  if (options.quiet) return;
  const ServerStatistics statistics = server.statistics();
  print_note(fmt::format(
      "stopped at {:.4f} s of the device: {} requests, {} of them refused; faults: {}\n",
      amplifier.time(), statistics.requests, statistics.exceptions,
      describe_faults(amplifier.faults())));
}

void add_noise_options(CLI::App& command, Options& options) {
  const char* group = "Noise and steps of what is measured";
  const auto add = [&](const char* name, std::string& value, const char* help) {
    command.add_option(name, value, help)->group(group);
  };
  add("--command-noise", options.command_noise,
      "Of what the amplifier puts out [A; V in voltage mode], by default 0.1 mA");
  add("--current-noise", options.current_noise, "Standard deviation, by default 1 mA");
  add("--voltage-noise", options.voltage_noise, "By default 5 mV");
  add("--velocity-noise", options.velocity_noise, "By default 0.02 rad/s or m/s");
  add("--position-noise", options.position_noise, "By default the model's sensor.noise");
  add("--current-step", options.current_step, "Of the converter, by default 0.5 mA; 0: none");
  add("--voltage-step", options.voltage_step, "By default 2 mV");
}

}  // namespace

void add_twin_command(CLI::App& app, int&) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "twin", "A simulated amplifier with the model's motor that speaks Modbus TCP or RTU");
  command->add_option("MODEL", options->model, "Model file (JSON)")->required()->check(not_empty());
  command->add_option("--listen", options->listen,
                      "HOST:PORT, by default 127.0.0.1:1502; port 0: any that is free");
  command->add_option("--rtu", options->rtu,
                      "A pseudo-terminal, which clients open under this path");
  command->add_option("--profile", options->profile,
                      "Registers: a profile's path or name, by default gyrator_twin");
  command->add_option("--unit", options->unit, "By default the profile's")
      ->check(whole_number_between(1, 247));
  command
      ->add_option("--baud", options->baud,
                   "Whose time the bytes take; by default 115200 for --rtu, none for TCP")
      ->check(whole_number_between(300, 4000000));
  command->add_option("--turnaround", options->turnaround,
                      "From request to answer, by default 1 ms");
  command->add_option("--time-scale", options->time_scale,
                      "real, a factor, or max: time passes with requests only");
  command->add_option("--winding-rise", options->winding_rise,
                      "Of the winding above the ambient at the start, by default the model's");
  command->add_option("--ambient", options->ambient, "By default 298.15 K, the model's reference");
  command->add_option("--velocity-limit", options->velocity_limit,
                      "Of the overspeed fault, by default 1000 rad/s or 10 m/s");
  command->add_option("--seed", options->seed, "Of all noise, by default the model's");
  command->add_option(
      "--misbehave", options->misbehave,
      "busy, late, drop, silent, garble, half, echo = probability; stuck = register");
  command->add_flag("--allow-remote", options->allow_remote,
                    "Listen to other machines, too: nothing is encrypted, nobody asked for a name");
  command->add_flag("--quiet", options->quiet, "Print the address only");
  add_noise_options(*command, *options);
  command->footer(
      "The first line on stdout is the address, \"listening on tcp://127.0.0.1:1502\".\n"
      "Ctrl-C and SIGTERM end it with exit code 0.\n"
      "Example:\n"
      "  gyrator twin examples/rc_display.json --listen 127.0.0.1:0 --time-scale max\n"
      "  gyrator twin examples/rc_display.json --rtu /tmp/amplifier --profile integer_drive");
  command->callback([options] { run_twin(*options); });
}

}  // namespace gyrator::app
