#pragma once

#include "gyrator/amplifiers/device_register.hpp"
#include "gyrator/amplifiers/experiment.hpp"
#include "gyrator/documents/document_spec.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

inline constexpr const char* amplifier_schema_name = "gyrator/amplifier/1";

/// A value to write for something to happen: "excitation_start" 1.
struct DeviceAction {
  std::string register_name;
  double value = 1;  ///< [SI]
};

/// How a device wants to be talked to; what libraries below need of it is in LinkOptions.
struct DeviceLink {
  int unit = 1;
  double response_timeout = 0.5, byte_timeout = 0.1, gap = 0;  ///< [s]
  int retries = 3;                                             ///< of reads
  double backoff = 0.02;                                       ///< [s]
  int max_read = 125, max_write = 123;                         ///< registers in a request
  int max_hole = 8;  ///< registers between two that are read together
  bool single_register_writes = true;
};

struct DeviceFault {
  std::string register_name;
  std::vector<std::pair<int, std::string>> bits;  ///< "overcurrent"
  std::optional<DeviceAction> clear;
};

/// A register that must be written again and again while the drive is on, or the device switches
/// it off by itself.
struct DeviceWatchdog {
  DeviceAction feed;
  double period = 0;  ///< longest time between two writes [s]
};

/// What makes the device keep its settings over a power cycle.
struct DevicePersist {
  DeviceAction action;
  std::string cost;
};

/// Of a simulated device, whose time is not the world's.
struct DeviceClock {
  std::string time, advance;  ///< names of registers [s]
};

/// The generator; a name is empty where there is no such register. Kinds of excitation and drive
/// modes are the codes of the registers `kind` and drive_mode: "dc", "sine", "current".
struct DeviceExcitation {
  std::string kind, amplitude, offset, frequency, end_frequency, duration;
  DeviceAction start, stop;
};

enum class CaptureSignal { command, current, voltage, velocity, position };
inline constexpr std::array capture_signals{CaptureSignal::command, CaptureSignal::current,
                                            CaptureSignal::voltage, CaptureSignal::velocity,
                                            CaptureSignal::position};
std::string_view name_of(CaptureSignal signal);

/// The capture buffer: `samples` values of each signal from the window's first address on, one
/// after another; with pages, the window shows `page_samples` of them, the first of which is page x
/// page_samples.
struct DeviceCapture {
  double period = 1e-4;  ///< between two samples that the device takes [s]
  int max_samples = 0;
  std::string delay;       ///< from the excitation's begin to the first sample [s]
  std::string decimation;  ///< every how manieth sample is kept; 1: all
  std::string samples;     ///< how many are kept
  DeviceAction arm;        ///< the capture begins with the next excitation
  std::string state;       ///< has a code "done"
  std::string page;        ///< empty: there are none
  int page_samples = 0;
  std::vector<std::pair<CaptureSignal, DeviceRegister>> signals;  ///< the first sample's register

  const DeviceRegister* find(CaptureSignal signal) const;
};

/// An amplifier as its maker's manual describes it: registers by name, and how to work with them.
struct DeviceProfile {
  std::string name, file;
  std::string digest;     ///< SHA-256 of the document
  nlohmann::json source;  ///< the document
  std::string caveats;
  DeviceLink link;
  std::vector<DeviceRegister> registers;
  std::vector<DeviceAction> identity;  ///< what registers read on such a device
  std::optional<DeviceFault> fault;
  std::optional<DeviceWatchdog> watchdog;
  std::optional<DevicePersist> persist;
  std::optional<DeviceClock> clock;
  std::optional<DeviceExcitation> excitation;
  std::optional<DeviceCapture> capture;

  const DeviceRegister* find(std::string_view register_name) const;
  /// Throws bad_input with the nearest name.
  const DeviceRegister& at(std::string_view register_name) const;
  std::vector<std::string> names() const;
};

/// Names that mean the same on every device (docs/amplifiers.md), with their units.
struct WellKnownName {
  std::string_view name;
  Unit unit;
  std::string_view meaning;
};
const std::vector<WellKnownName>& well_known_names();

/// The profile as a table: reader, JSON Schema (schemas/amplifier.schema.json) and manual.
const Member& amplifier_format();

/// A profile by its path, or a shipped one by name ("gyrator_twin"): looked for in the working
/// directory, in profiles/ there, and among the installed data. Throws bad_input, with file and
/// JSON pointer, for what is not as amplifier_format says, and for a profile that contradicts
/// itself: names given twice, registers on top of one another, a range that the type cannot hold, a
/// step off the register's resolution, limits out of order, references to registers that are not
/// there or cannot be read or written as they must be, bit fields for watchdog and clock or that
/// can only be written, units of another dimension than a well-known name has.
DeviceProfile load_device_profile(const std::string& path_or_name);
DeviceProfile parse_device_profile(const nlohmann::json& document, const std::string& file);

}  // namespace gyrator
