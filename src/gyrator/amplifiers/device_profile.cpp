#include "gyrator/amplifiers/device_profile.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/json_text.hpp"

#include <algorithm>
#include <filesystem>

namespace gyrator {
namespace {

std::optional<std::filesystem::path> find_profile_file(const std::string& given) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (fs::exists(given, ignored) || given.find('/') != std::string::npos) return given;
  std::vector<fs::path> folders{".", "profiles"};
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  if (!program.empty()) {
    const fs::path folder = program.parent_path();
    folders.insert(folders.end(), {folder / "../share/gyrator/profiles", folder / "../../profiles",
                                   folder / "../profiles"});
  }
  for (const fs::path& folder : folders) {
    for (const std::string& name : {given, given + ".json"})
      if (fs::is_regular_file(folder / name, ignored)) return (folder / name).lexically_normal();
  }
  return {};
}

}  // namespace

std::string_view name_of(CaptureSignal signal) {
  constexpr std::array<std::string_view, 5> names{"command", "current", "voltage", "velocity",
                                                  "position"};
  return names.at(static_cast<std::size_t>(signal));
}

const DeviceRegister* DeviceCapture::find(CaptureSignal signal) const {
  for (const auto& [known, place] : signals)
    if (known == signal) return &place;
  return nullptr;
}

const DeviceRegister* DeviceProfile::find(std::string_view register_name) const {
  const auto found = std::find_if(registers.begin(), registers.end(),
                                  [&](const auto& place) { return place.name == register_name; });
  return found == registers.end() ? nullptr : &*found;
}

const DeviceRegister& DeviceProfile::at(std::string_view register_name) const {
  if (const DeviceRegister* place = find(register_name)) return *place;
  throw Error(ErrorCode::bad_input, name,
              describe_unknown_name("register", register_name, names()));
}

std::vector<std::string> DeviceProfile::names() const {
  std::vector<std::string> all;
  for (const DeviceRegister& place : registers) all.push_back(place.name);
  return all;
}

const std::vector<WellKnownName>& well_known_names() {
  static const std::vector<WellKnownName> names{
      {"enable", dimension::none, "the drive is on"},
      {"drive_mode", dimension::none, "what the command is: codes current, voltage"},
      {"current_limit", dimension::current, "the amplifier gives no more"},
      {"voltage_limit", dimension::voltage, "the amplifier gives no more"},
      {"temperature_limit", dimension::temperature, "of the winding; beyond it a fault"},
      {"cancellation_resistance", dimension::resistance, "of the winding, cancelled"},
      {"damping_resistance", dimension::resistance, "across the motor"},
      {"damping_capacitance", dimension::capacitance, "in series with damping_resistance"},
      {"damping_connected", dimension::none, "resistance and capacitance are across the motor"},
      {"back_emf_damping", dimension::rotary_damping, "by feedback of the back-EMF"},
      {"back_emf_damping", dimension::linear_damping, "by feedback of the back-EMF"},
      {"back_emf_resistance", dimension::resistance, "of the winding, for the back-EMF's estimate"},
      {"current", dimension::current, "in the winding, now"},
      {"voltage", dimension::voltage, "at the motor's terminals, now"},
      {"velocity", dimension::angular_velocity, "of the rotor, now"},
      {"velocity", dimension::velocity, "of the slider, now"},
      {"position", dimension::angle, "of the rotor, now"},
      {"position", dimension::length, "of the slider, now"},
      {"winding_temperature", dimension::temperature, "now"},
      {"fault", dimension::none, "bits of what is wrong"},
      {"device_time", dimension::time, "of a simulated device"},
      {"advance_time", dimension::time, "moves the time of a simulated device"},
  };
  return names;
}

DeviceProfile load_device_profile(const std::string& path_or_name) {
  const auto path = find_profile_file(path_or_name);
  if (!path) {
    throw Error(ErrorCode::bad_input, path_or_name,
                "no such profile: a path is expected, or the name of a shipped one: gyrator_twin, "
                "integer_drive");
  }
  return parse_device_profile(load_json_file(*path), path->string());
}

}  // namespace gyrator
