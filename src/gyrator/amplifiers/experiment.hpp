#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// What an amplifier's command is: the current that it is to deliver [A], or its terminal voltage
/// [V].
enum class DriveMode { current, voltage };
std::string_view name_of(DriveMode mode);
/// Of such a command: "A" or "V".
std::string_view unit_of(DriveMode mode);

enum class ExcitationKind { dc, step, sine, chirp, prbs };
std::string_view name_of(ExcitationKind kind);

/// What an amplifier's generator plays. With o the offset, a the amplitude, d the duration, f the
/// frequency and f' the end frequency, for 0 <= t < d
///   dc      u = o
///   step    u = o before d/4, o + a from there
///   sine    u = o + a sin(2 pi f t)
///   chirp   u = o + a sin(2 pi (f t + (f' - f) t^2 / (2 d)))
///   prbs    u = o ± a, a maximal sequence of 2^15 - 1 bits, f bits per second          (excite-1)
/// and u = 0 for any other t.
struct Excitation {
  ExcitationKind kind = ExcitationKind::dc;
  DriveMode mode = DriveMode::current;
  double amplitude = 0;         ///< a [A or V]
  double offset = 0;            ///< o [A or V]
  double frequency_hz = 0;      ///< of sine and chirp; bits per second of prbs
  double end_frequency_hz = 0;  ///< of the chirp
  double duration = 0;          ///< d [s]
};

/// The command at t [s] after the excitation's begin [A or V].
double compute_command(const Excitation& excitation, double t);

/// The largest |u| that it reaches [A or V].
double find_peak(const Excitation& excitation);

/// "sine of 50 mA about 0 A, 40 Hz, 0.5 s", for messages and plans.
std::string describe(const Excitation& excitation);

/// Throws bad_input for what is not finite, a duration or a frequency that is not positive.
void check_excitation(const Excitation& excitation);

/// What to keep of a run: `samples` instants, `period` [s] apart, the first at `start` [s] after
/// the excitation's begin.
struct CaptureRequest {
  double start = 0;
  double period = 1e-4;
  int samples = 0;
};

/// What an amplifier's capture buffer held, all at the same instants; a signal that it does not
/// offer is empty.
struct Capture {
  double start = 0;              ///< of the first sample after the excitation's begin [s]
  double period = 0;             ///< [s]
  std::vector<double> command;   ///< that the generator gave [A or V]
  std::vector<double> current;   ///< in the winding [A]
  std::vector<double> voltage;   ///< at the motor's terminals [V]
  std::vector<double> velocity;  ///< [rad/s, m/s]
  std::vector<double> position;  ///< [rad, m]
  std::optional<double> winding_temperature_before, winding_temperature_after;  ///< [K]
};

/// What an amplifier can do and may be asked for.
struct BenchLimits {
  double shortest_period = 1e-4;  ///< of the capture, all others are multiples of it [s]
  int most_samples = 4000;
  double largest_current = 0;    ///< that may be asked for and flow [A]
  double largest_voltage = 0;    ///< [V]
  double largest_velocity = 0;   ///< [rad/s, m/s]; 0: none is known
  double longest_duration = 60;  ///< of an excitation [s]
  double lowest_frequency_hz = 0.1, highest_frequency_hz = 5000;  ///< of the generator
  double position_quantum = 0;  ///< of the capture [rad, m]; 0: unknown
  std::vector<DriveMode> modes;
  std::vector<ExcitationKind> kinds;
};

/// The value of a setting.
struct Setting {
  std::string name;  ///< well-known (docs/amplifiers.md)
  double value = 0;  ///< SI; switches 0 or 1
};

/// The values that a setting may take: low, low + step … up to high; step 0: all between.
struct SettingRange {
  double low = 0, high = 0, step = 0;
};

/// An amplifier with a motor, on the bench: real behind Modbus, or simulated in this process.
class Bench {
 public:
  Bench() = default;
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  virtual ~Bench() = default;

  virtual BenchLimits limits() const = 0;

  /// Plays the excitation with the drive on, keeps what is asked for, and switches the drive off.
  /// Current, temperature and faults are watched meanwhile. Throws device, after the drive has been
  /// switched off, for a fault, a limit or a lost link; bad_input for what the amplifier cannot do.
  virtual Capture run(const Excitation& excitation, const CaptureRequest& request) = 0;

  /// Of the winding [K]; none where the amplifier does not know.
  virtual std::optional<double> winding_temperature() = 0;

  /// Lets time pass, of the device [s].
  virtual void wait(double seconds) = 0;

  /// Settings by their well-known names (docs/amplifiers.md), in SI units, switches as 0 and 1.
  virtual bool has_setting(std::string_view name) const = 0;
  virtual SettingRange setting_range(std::string_view name) const = 0;
  virtual double read_setting(std::string_view name) = 0;
  virtual void write_setting(std::string_view name, double value) = 0;
};

}  // namespace gyrator
