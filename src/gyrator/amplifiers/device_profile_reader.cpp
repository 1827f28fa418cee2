// From the document to registers and blocks, with the place of whatever is wrong.
#include "gyrator/amplifiers/device_profile.hpp"
#include "gyrator/amplifiers/device_profile_checks.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/digest.hpp"
#include "gyrator/documents/document_reader.hpp"

#include <algorithm>
#include <set>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& where, const std::string& message) {
  throw Error(ErrorCode::bad_input, where, message);
}

// A number in the register's unit, a text with a unit, or a code's name.
double read_value(const json& value, const DeviceRegister& place, const std::string& where) {
  if (value.is_boolean()) return value.get<bool>() ? 1 : 0;
  if (value.is_number()) return value.get<double>() * place.factor;
  if (!value.is_string()) refuse(where, value.dump() + ": a number, a quantity or a code expected");
  try {
    return parse_register_value(place, value.get<std::string>());
  } catch (const Error& error) {
    refuse(where, error.message());
  }
}

std::optional<double> read_optional(const json& value, const DeviceRegister& place,
                                    const std::string& where) {
  if (value.is_null()) return {};
  return read_value(value, place, where);
}

void read_unit(const json& entry, DeviceRegister& place, const std::string& where) {
  place.unit = entry["unit"];
  if (place.unit.empty()) return;
  try {
    const Quantity one = parse_quantity("1 " + place.unit);
    place.factor = one.value;
    place.dimension = one.dimension;
  } catch (const Error& error) {
    refuse(where + "/unit", error.message());
  }
  if (!place.dimension || *place.dimension == Dimension{}) {
    place.dimension.reset();
    return;
  }
  const std::string text = describe_dimension(*place.dimension);
  const std::size_t open = text.find('[');
  place.symbol = open == std::string::npos ? text.substr(text.rfind(' ') + 1)
                                           : text.substr(open + 1, text.size() - open - 2);
}

void read_codes(const json& codes, DeviceRegister& place, const std::string& where) {
  if (codes.is_null()) return;
  if (!codes.is_object() || codes.empty())
    refuse(where, "an object of names and numbers is expected: {\"current\": 0, \"voltage\": 1}");
  for (const auto& [name, code] : codes.items()) {
    if (!code.is_number_integer())
      refuse(where + "/" + name, code.dump() + ": a whole number is expected");
    place.codes.emplace_back(name, code.get<std::int64_t>());
  }
}

void read_sentinel(const json& value, DeviceRegister& place, const std::string& where) {
  if (value.is_null()) return;
  if (!value.is_number()) refuse(where, value.dump() + ": the raw number is expected");
  if (value.is_number_unsigned()) {
    place.not_implemented = value.get<std::uint64_t>();
  } else if (value.is_number_integer()) {
    place.not_implemented = value.get<std::int64_t>();
  } else {
    place.not_implemented = value.get<double>();
  }
  try {
    encode_value(*place.not_implemented, place.type, place.order);
  } catch (const Error& error) {
    refuse(where, error.message());
  }
}

// What a register and a capture's window have in common.
DeviceRegister read_number(const json& entry, WordOrder order, const std::string& where) {
  DeviceRegister place;
  place.table = *find_register_table(entry["table"].get<std::string>());
  place.address = entry["address"];
  place.order =
      entry["order"].is_null() ? order : *find_word_order(entry["order"].get<std::string>());
  if (!entry["type"].is_null()) {
    place.type = *find_register_type(entry["type"].get<std::string>());
  } else if (holds_bits(place.table)) {
    place.type = RegisterType::bit;
  } else {
    refuse(where, "is missing 'type': how the number is written, such as \"f32\"");
  }
  place.scale = entry["scale"];
  place.offset = entry["offset"];
  read_unit(entry, place, where);
  read_sentinel(entry["not_implemented"], place, where + "/not_implemented");
  return place;
}

DeviceRegister read_register(const json& entry, WordOrder order, const std::string& where) {
  DeviceRegister place = read_number(entry, order, where);
  place.name = entry["name"];
  place.group = entry["group"];
  place.caveat = entry["caveat"];
  place.write_cost = entry["write_cost"];
  place.persistent = entry["store"] == "persistent";
  place.settle = entry["settle"];
  if (!entry["bits"].is_null()) place.bits = {entry["bits"]["first"], entry["bits"]["count"]};
  read_codes(entry["codes"], place, where + "/codes");
  const bool may_write = is_writable(place.table);
  const std::string access = entry["access"].is_null() ? (may_write ? "read_write" : "read")
                                                       : entry["access"].get<std::string>();
  place.readable = access != "write";
  place.writable = access != "read";
  place.low = read_optional(entry["min"], place, where + "/min");
  place.high = read_optional(entry["max"], place, where + "/max");
  place.step = read_optional(entry["step"], place, where + "/step");
  place.safe = read_optional(entry["safe"], place, where + "/safe");
  return place;
}

enum class Use { read, write };

// Reads the blocks, each of whose names must be a register that can be used so.
class BlockReader {
 public:
  BlockReader(DeviceProfile& profile, const std::string& file) : profile_(profile), file_(file) {}

  // Names of registers that belong to a block are no settings.
  const std::set<std::string>& used() const { return used_; }

  const DeviceRegister& find(const json& name, Use use, const std::string& pointer) {
    const std::string where = file_ + ": " + pointer;
    const DeviceRegister* place = profile_.find(name.get<std::string>());
    if (place == nullptr)
      refuse(where, describe_unknown_name("register", name.get<std::string>(), profile_.names()));
    if (use == Use::read && !place->readable)
      refuse(where, fmt::format("'{}': cannot be read, by its access", place->name));
    if (use == Use::write && !place->writable)
      refuse(where, fmt::format("'{}': cannot be written, by its access", place->name));
    used_.insert(place->name);
    return *place;
  }

  std::string name(const json& block, const char* key, Use use, const std::string& pointer) {
    if (block[key].is_null()) return {};
    return find(block[key], use, pointer + "/" + key).name;
  }

  DeviceAction action(const json& block, Use use, const std::string& pointer) {
    const DeviceRegister& place = find(block["register"], use, pointer + "/register");
    const std::string where = file_ + ": " + pointer + "/value";
    DeviceAction action{place.name, read_value(block["value"], place, where)};
    try {
      if (use == Use::write) to_raw(place, action.value);
    } catch (const Error& error) {
      refuse(where, error.message());
    }
    return action;
  }

  void require_code(const std::string& register_name, const char* code,
                    const std::string& pointer) const {
    const DeviceRegister& place = profile_.at(register_name);
    if (find_code(place, code)) return;
    refuse(file_ + ": " + pointer,
           fmt::format("'{}': must have a code \"{}\"", register_name, code));
  }

 private:
  DeviceProfile& profile_;
  std::string file_;
  std::set<std::string> used_;
};

DeviceFault read_fault(const json& block, BlockReader& reader, const DeviceProfile& profile) {
  DeviceFault fault;
  const DeviceRegister& place = reader.find(block["register"], Use::read, "/fault/register");
  fault.register_name = place.name;
  const std::string where = profile.file + ": /fault/bits";
  if (!block["bits"].is_object() || block["bits"].empty())
    refuse(where, "an object of bits and meanings is expected: {\"0\": \"overcurrent\"}");
  const int most = place.type == RegisterType::bit ? 1 : 16 * place.words();
  for (const auto& [bit, meaning] : block["bits"].items()) {
    const bool is_number =
        !bit.empty() && bit.size() <= 2 && bit.find_first_not_of("0123456789") == std::string::npos;
    if (!is_number || std::stoi(bit) >= most)
      refuse(where, fmt::format("'{}': a bit from 0 to {} is expected", bit, most - 1));
    if (!meaning.is_string()) refuse(where + "/" + bit, "a text is expected");
    fault.bits.emplace_back(std::stoi(bit), meaning.get<std::string>());
  }
  std::sort(fault.bits.begin(), fault.bits.end());
  if (!block["clear"].is_null())
    fault.clear = reader.action(block["clear"], Use::write, "/fault/clear");
  return fault;
}

DeviceExcitation read_excitation(const json& block, BlockReader& reader) {
  const auto name = [&](const char* key) {
    return reader.name(block, key, Use::write, "/excitation");
  };
  DeviceExcitation excitation{name("kind"),
                              name("amplitude"),
                              name("offset"),
                              name("frequency"),
                              name("end_frequency"),
                              name("duration"),
                              {},
                              {}};
  excitation.start = reader.action(block["start"], Use::write, "/excitation/start");
  excitation.stop = reader.action(block["stop"], Use::write, "/excitation/stop");
  return excitation;
}

void check_kinds(const DeviceProfile& profile) {
  const DeviceRegister& kind = profile.at(profile.excitation->kind);
  std::vector<std::string> known;
  for (const auto each : {ExcitationKind::dc, ExcitationKind::step, ExcitationKind::sine,
                          ExcitationKind::chirp, ExcitationKind::prbs})
    known.emplace_back(name_of(each));
  const std::string where = profile.file + ": /excitation/kind";
  if (kind.codes.empty())
    refuse(where, fmt::format("'{}': must have codes, of {}", kind.name, join(known)));
  for (const auto& [name, code] : kind.codes) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      refuse(where, describe_unknown_name("kind of excitation", name, known));
  }
}

DeviceCapture read_capture(const json& block, BlockReader& reader, WordOrder order,
                           const std::string& file) {
  DeviceCapture capture;
  capture.period = block["period"];
  capture.max_samples = block["max_samples"];
  const auto name = [&](const char* key, Use use) {
    return reader.name(block, key, use, "/capture");
  };
  capture.delay = name("delay", Use::write);
  capture.decimation = name("decimation", Use::write);
  capture.samples = name("samples", Use::write);
  capture.arm = reader.action(block["arm"], Use::write, "/capture/arm");
  capture.state = name("state", Use::read);
  reader.require_code(capture.state, "done", "/capture/state");
  if (!block["page"].is_null()) {
    capture.page = reader.name(block["page"], "register", Use::write, "/capture/page");
    capture.page_samples = block["page"]["samples"];
  }
  for (const CaptureSignal signal : capture_signals) {
    const json& window = block["signals"][std::string(name_of(signal))];
    if (window.is_null()) continue;
    const std::string where = fmt::format("{}: /capture/signals/{}", file, name_of(signal));
    DeviceRegister place = read_number(window, order, where);
    place.name = fmt::format("capture of {}", name_of(signal));
    check_register(place, where);
    capture.signals.emplace_back(signal, std::move(place));
  }
  if (capture.signals.empty()) refuse(file + ": /capture/signals", "no signal is kept");
  return capture;
}

void read_blocks(const json& read, DeviceProfile& profile, WordOrder order,
                 std::set<std::string>& used) {
  BlockReader reader(profile, profile.file);
  for (std::size_t i = 0; i < read["identity"].size(); ++i)
    profile.identity.push_back(
        reader.action(read["identity"][i], Use::read, fmt::format("/identity/{}", i)));
  if (!read["fault"].is_null()) profile.fault = read_fault(read["fault"], reader, profile);
  if (!read["watchdog"].is_null()) {
    profile.watchdog = {reader.action(read["watchdog"], Use::write, "/watchdog"),
                        read["watchdog"]["period"]};
  }
  if (!read["persist"].is_null()) {
    profile.persist = {reader.action(read["persist"], Use::write, "/persist"),
                       read["persist"]["cost"]};
  }
  if (!read["clock"].is_null()) {
    profile.clock = {reader.name(read["clock"], "time", Use::read, "/clock"),
                     reader.name(read["clock"], "advance", Use::write, "/clock")};
  }
  if (!read["excitation"].is_null()) {
    profile.excitation = read_excitation(read["excitation"], reader);
    check_kinds(profile);
  }
  if (!read["capture"].is_null())
    profile.capture = read_capture(read["capture"], reader, order, profile.file);
  used = reader.used();
}

DeviceLink read_link(const json& block) {
  DeviceLink link;
  link.unit = block["unit"];
  link.response_timeout = block["response_timeout"];
  link.byte_timeout = block["byte_timeout"];
  link.gap = block["gap"];
  link.retries = block["retries"];
  link.backoff = block["backoff"];
  link.max_read = block["max_read"];
  link.max_write = block["max_write"];
  link.max_hole = block["max_hole"];
  link.single_register_writes = block["single_register_writes"];
  return link;
}

// A setting must be read to be kept and written to be put back.
void decide_settings(const json& read, DeviceProfile& profile, const std::set<std::string>& used) {
  for (std::size_t i = 0; i < profile.registers.size(); ++i) {
    DeviceRegister& place = profile.registers[i];
    const json& asked = read["registers"][i]["setting"];
    const bool can = place.readable && place.writable;
    place.is_setting = asked.is_null() ? can && !used.contains(place.name) : asked.get<bool>();
    if (place.is_setting && !can)
      refuse(fmt::format("{}: /registers/{}/setting", profile.file, i),
             "true: a setting must be read and written");
  }
}

}  // namespace

DeviceProfile parse_device_profile(const json& document, const std::string& file) {
  const json read = read_document(document, amplifier_format(), file);
  DeviceProfile profile;
  profile.name = read["name"];
  profile.file = file;
  profile.caveats = read["caveats"];
  profile.source = document;
  profile.digest = compute_sha256(document.dump());
  const WordOrder order = *find_word_order(read["order"].get<std::string>());
  profile.link = read_link(read["link"]);
  for (std::size_t i = 0; i < read["registers"].size(); ++i) {
    profile.registers.push_back(
        read_register(read["registers"][i], order, fmt::format("{}: /registers/{}", file, i)));
  }
  check_device_profile(profile);
  std::set<std::string> used;
  read_blocks(read, profile, order, used);
  check_device_profile(profile);  // now with the windows of the capture
  decide_settings(read, profile, used);
  return profile;
}

}  // namespace gyrator
