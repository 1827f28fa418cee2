#pragma once

#include "gyrator/amplifiers/experiment.hpp"
#include "gyrator/core/random_stream.hpp"
#include "gyrator/twin/twin_device.hpp"
#include "gyrator/twin/twin_plant.hpp"
#include "gyrator/twin/winding_heat.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// Why an amplifier has switched itself off; bit numbers of its fault register.
enum class TwinFault {
  overcurrent,      ///< |i| of the motor above 1.25 of current_limit
  overvoltage,      ///< the output above 1.25 of voltage_limit, looked at every 1 ms
  overtemperature,  ///< the winding above temperature_limit
  overspeed,        ///< above velocity_limit
  instability,      ///< stored energy grows while the command is zero, looked at every 1 ms
  watchdog          ///< not fed for watchdog_period while the drive was on
};
inline constexpr int twin_fault_count = 6;
std::string_view name_of(TwinFault fault);

/// "overcurrent, watchdog" of a fault register's bits; "none".
std::string describe_faults(unsigned bits);

enum class CaptureState { idle, armed, busy, done };

/// What is truly there, without noise and quantization.
struct TwinTruth {
  double current = 0;              ///< in the winding [A]
  double voltage = 0;              ///< at the terminals, where the damping branch hangs [V]
  double velocity = 0;             ///< where the sensor is [rad/s, m/s]
  double position = 0;             ///< [rad, m]
  double winding_temperature = 0;  ///< [K]
  double stored_energy = 0;        ///< in inductors, capacitors, masses and springs [J]
};

/// A power amplifier with a motor on the bench, simulated: settings, generator, protection and
/// capture buffer in ticks of 100 us, and between them the plant, exactly.
///
/// In each tick: generator (excite-1) → bounded by the limit of its kind → noise → delay → plant
/// under a held command; the capture takes the instant's values before the command jumps. The
/// velocity is that of a tachometer: the true one plus noise, not a difference of positions. The
/// winding warms beside the plant (thermal-1); the plant's resistance follows when it is
/// `resistance_step` off, so that the electrical loss is within that part of the heat. A setting
/// that changes the circuit builds a new plant, into which all that is stored goes over; none is
/// built in a tick otherwise. The capacitor of a branch that is not connected keeps its charge.
///
/// A fault disables: the terminals are then open but for the damping branch, and the generator is
/// off. It stays until cleared, and as long the drive cannot be enabled. A motor that is at rest
/// with the drive off (below 1e-15 J) only cools, in one step. Deterministic: the same calls give
/// the same numbers.
class SimulatedAmplifier {
 public:
  static constexpr std::int64_t ticks_per_second = 10000;
  static constexpr double tick = 1.0 / ticks_per_second;  ///< [s]
  static constexpr double resistance_step = 1e-4;         ///< relative
  static constexpr int most_samples = 4000;

  /// Throws bad_input as check_twin_device().
  explicit SimulatedAmplifier(const TwinDevice& twin);

  /// Lets time pass. `watched` false: the watchdog's does not (nobody could feed it).
  void advance_ticks(std::int64_t ticks, bool watched = true);
  /// The same, to the nearest tick.
  void advance(double seconds, bool watched = true);
  std::int64_t ticks() const { return now_; }
  double time() const { return static_cast<double>(now_) / ticks_per_second; }  ///< [s]

  // Settings and actual values by well-known name, in SI units, switches as 0 and 1. Actual values
  // have noise and steps of their sensors. `clear_fault` and `watchdog` act when written.
  static bool has_setting(std::string_view name);
  static bool has_actual(std::string_view name);
  static const std::vector<std::string>& setting_names();
  static const std::vector<std::string>& actual_names();
  /// Throws bad_input for a name that is neither.
  double read(std::string_view name);
  /// Throws bad_input for an unknown name, a value out of range, and a circuit that cannot be;
  /// device where it is refused: enabling with a fault, the drive mode while enabled. Nothing has
  /// changed then.
  void write(std::string_view name, double value);
  const TwinSettings& settings() const { return settings_; }

  unsigned faults() const { return faults_; }
  void clear_faults();
  void feed_watchdog() { fed_ = watched_ticks_; }

  /// Starts the generator now. Throws bad_input for an excitation that makes no sense, device where
  /// the drive is off or in another mode.
  void start(const Excitation& excitation);
  void stop();
  bool is_exciting() const { return excitation_.has_value(); }

  /// The next excitation is captured. Throws bad_input for times that are no multiples of the tick
  /// and more samples than fit.
  void arm(const CaptureRequest& request);
  CaptureState capture_state() const { return capture_state_; }
  /// Ticks until an armed and triggered capture is done; 0 otherwise.
  std::int64_t ticks_to_capture() const;
  const Capture& capture() const { return capture_; }
  double winding_temperature() const { return twin_.ambient + heat_.rise(); }  ///< [K]

  TwinTruth truth();
  const TwinDevice& device() const { return twin_; }
  /// Plants that were built so far, the first included.
  long plants_built() const { return plants_built_; }

 private:
  void step(bool watched);
  bool is_at_rest();
  void rest(std::int64_t ticks, bool watched);
  void follow_winding();
  void record();
  void protect();
  void watch_energy();
  void trip(TwinFault fault);
  void apply(const TwinSettings& wanted);
  void rebuild(const TwinSettings& settings, double resistance);
  double sense(double value, double noise, double step, RandomStream& random) const;
  double bound(double command) const;
  double delivered(double current) const;
  void reset_commands();

  TwinDevice twin_;
  TwinSettings settings_;
  double supply_current_;  ///< that heats at most, however fast an unstable drive grows [A]
  WindingHeat heat_;
  std::unique_ptr<RailedPlant> plant_;
  double plant_resistance_ = 0;  ///< that the plant was built with [ohm]
  long plants_built_ = 0;
  double charge_ = 0;  ///< voltage of the branch's capacitor while it is not connected [V]

  std::int64_t now_ = 0, watched_ticks_ = 0, fed_ = 0;
  unsigned faults_ = 0;
  double current_ = 0;  ///< true, at this instant [A]

  std::optional<Excitation> excitation_;
  std::int64_t excitation_began_ = 0;
  double command_ = 0;              ///< of the generator at the last tick [A or V]
  std::vector<double> on_the_way_;  ///< commands, a ring: the oldest at next_
  std::size_t next_ = 0;
  double held_ = 0;  ///< command that acts on the plant now [A or V]

  CaptureState capture_state_ = CaptureState::idle;
  Capture capture_;
  std::int64_t capture_start_ = 0, capture_every_ = 1, capture_next_ = 0;
  std::size_t capture_size_ = 0;

  std::int64_t quiet_since_ = 0;  ///< tick since which the command has been zero
  double least_energy_ = 0;       ///< since then [J]
  double watched_floor_ = 0;      ///< energy below which growth is noise [J]

  RandomStream command_noise_, current_noise_, voltage_noise_, velocity_noise_, position_noise_,
      reading_noise_;
};

}  // namespace gyrator
