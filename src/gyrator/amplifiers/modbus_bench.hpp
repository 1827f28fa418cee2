#pragma once

#include "gyrator/amplifiers/amplifier_port.hpp"
#include "gyrator/amplifiers/experiment.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// The registers that generator, buffer, switch, watchdog and clock need for experiments, each
/// once.
std::vector<std::string> find_experiment_registers(const DeviceProfile& profile);

/// An amplifier behind Modbus as a bench: its generator and its capture buffer through an
/// AmplifierPort that may write.
///
/// A run writes generator and buffer with the drive off, arms, switches on, starts, looks at state,
/// faults, current, speed and temperature until the buffer is full, switches off, and reads it in
/// blocks. If anything goes wrong the drive is switched off before the error goes on; where that
/// could not be, or only with the whole safe state, the error says so and what came before it.
class ModbusBench final : public Bench {
 public:
  /// Throws bad_input where the profile has no generator or no capture buffer, or where one of
  /// find_experiment_registers is in persistent memory, which experiments would wear out; reads the
  /// limits that the device has set. The port outlives the bench.
  explicit ModbusBench(AmplifierPort& port);

  /// The currents and voltages are those of the device's own limits as they are set now, or the
  /// command line's where they are lower.
  BenchLimits limits() const override { return limits_; }
  Capture run(const Excitation& excitation, const CaptureRequest& request) override;
  std::optional<double> winding_temperature() override;
  void wait(double seconds) override { port_.wait(seconds); }
  bool has_setting(std::string_view name) const override;
  /// By profile and command line; the step of a whole number is its resolution at least.
  SettingRange setting_range(std::string_view name) const override;
  double read_setting(std::string_view name) override { return port_.read_value(name); }
  /// With the drive off, which it switches off if need be. Throws device for a register in
  /// persistent memory that has not this value already: AmplifierPort::write is for what is kept.
  void write_setting(std::string_view name, double value) override;
  /// What a command is; with the drive off. Throws bad_input for a mode that the amplifier does not
  /// have.
  void set_mode(DriveMode mode);

 private:
  void read_limits();
  void check_request(const Excitation& excitation, const CaptureRequest& request) const;
  void set_up(const Excitation& excitation, const CaptureRequest& request);
  void play(const Excitation& excitation, const CaptureRequest& request);
  bool look();
  void check_faults(const char* when);
  void switch_off(const std::string& cause);
  void read_buffer(int samples, Capture& capture);

  AmplifierPort& port_;
  const DeviceExcitation& excitation_;
  const DeviceCapture& capture_;
  BenchLimits limits_;
  std::optional<double> hottest_;  // that the winding may be [K]
  bool is_off_ = false;            // the drive, as far as is known
};

}  // namespace gyrator
