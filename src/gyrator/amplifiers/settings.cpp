#include "gyrator/amplifiers/settings.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/json_text.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

json number_or_null(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

const ObjectSpec& backup_format() {
  static const ObjectSpec format{
      "backup",
      "All settings of an amplifier at one time, for `gyrator diff` and `restore`.",
      {
          member::choice("schema", {backup_schema_name}).required().doc("Version of the format."),
          member::text("profile").required().doc("Name of the profile that they were read by."),
          member::text("digest").required().doc("Of that profile."),
          member::text("device").required().doc("Where it was."),
          member::text("time").required().doc("When, UTC."),
          member::text("program").doc("That wrote it."),
          member::object(
              "settings",
              {"setting",
               "One register's content.",
               {
                   member::text("register").required().doc("By name."),
                   member::text("address").required().doc("For people."),
                   member::integer("words").list(1, 4).at_least(0).at_most(65535).required().doc(
                       "As the device holds it; what a restore writes."),
                   member::anything("value").doc("The same in SI units, for people."),
                   member::text("unit").doc("Of the value."),
               }})
              .list()
              .required()
              .doc("All of them."),
          member::text("unreadable")
              .list()
              .by_default(json::array())
              .doc("What could not be read."),
      }};
  return format;
}

std::string describe_side(const SettingChange& change, const std::optional<SettingValue>& side) {
  if (!side) return "absent";
  if (!side->value) return "no value";
  return describe_value(*change.place, *side->value);
}

using Row = std::vector<std::string>;

// Names and addresses to the left, values to the right.
std::string align_rows(const std::vector<Row>& rows) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const Row& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      text += i == 0 ? "" : "  ";
      text += i < 2 ? fmt::format("{:<{}}", row[i], widths[i])
                    : fmt::format("{:>{}}", row[i], widths[i]);
    }
    text += "\n";
  }
  return text;
}

}  // namespace

const SettingValue* SettingsBackup::find(std::string_view name) const {
  const auto found = std::find_if(settings.begin(), settings.end(),
                                  [&](const SettingValue& each) { return each.name == name; });
  return found == settings.end() ? nullptr : &*found;
}

SettingValue take_value(const DeviceRegister& place, std::vector<std::uint16_t> words) {
  SettingValue value{place.name, std::move(words), 0, {}};
  const RawValue raw = take_raw(place, value.words);
  value.pattern =
      place.bits ? std::get<std::uint64_t>(raw) : decode_pattern(value.words, place.order);
  value.value = to_physical(place, raw);
  return value;
}

std::vector<SettingChange> compare_settings(const DeviceProfile& profile,
                                            const SettingsBackup& before,
                                            const SettingsBackup& after) {
  std::vector<SettingChange> changes;
  for (const DeviceRegister& place : profile.registers) {
    const SettingValue* old = before.find(place.name);
    const SettingValue* now = after.find(place.name);
    if (old == nullptr && now == nullptr) continue;
    if (old != nullptr && now != nullptr && old->pattern == now->pattern) continue;
    SettingChange change{&place, {}, {}};
    if (old != nullptr) change.before = *old;
    if (now != nullptr) change.after = *now;
    changes.push_back(std::move(change));
  }
  return changes;
}

std::vector<SettingChange> order_safely(std::vector<SettingChange> changes) {
  const auto switches_on = [](const SettingChange& change) {
    return change.place->name == "enable" && change.after && change.after->pattern != 0;
  };
  const auto switches_off = [](const SettingChange& change) {
    return change.place->name == "enable" && change.after && change.after->pattern == 0;
  };
  std::stable_partition(changes.begin(), changes.end(), switches_off);
  std::stable_partition(changes.begin(), changes.end(),
                        [&](const SettingChange& change) { return !switches_on(change); });
  return changes;
}

json describe_backup(const SettingsBackup& backup, const DeviceProfile& profile) {
  json settings = json::array();
  for (const SettingValue& each : backup.settings) {
    const DeviceRegister& place = profile.at(each.name);
    settings.push_back({{"register", each.name},
                        {"address", place.describe_place()},
                        {"words", each.words},
                        {"value", number_or_null(each.value)},
                        {"unit", place.symbol}});
  }
  return {{"schema", backup_schema_name},
          {"profile", backup.profile},
          {"digest", backup.digest},
          {"device", backup.device},
          {"time", backup.time},
          {"settings", std::move(settings)},
          {"unreadable", backup.unreadable}};
}

SettingsBackup parse_backup(const json& document, const DeviceProfile& profile,
                            const std::string& file) {
  const json read = read_document(document, backup_format(), file);
  SettingsBackup backup{read["profile"], read["digest"], read["device"], read["time"], {}, {}};
  for (std::size_t i = 0; i < read["settings"].size(); ++i) {
    const json& entry = read["settings"][i];
    const std::string where = fmt::format("{}: /settings/{}", file, i);
    const DeviceRegister* place = profile.find(entry["register"].get<std::string>());
    if (place == nullptr || !place->is_setting) {
      throw Error(ErrorCode::bad_input, where + "/register",
                  fmt::format("{}: is no setting of the profile {}", entry["register"].dump(),
                              profile.name));
    }
    auto words = entry["words"].get<std::vector<std::uint16_t>>();
    if (static_cast<int>(words.size()) != place->words()) {
      throw Error(
          ErrorCode::bad_input, where + "/words",
          fmt::format("{} words: {} has {}", words.size(), name_of(place->type), place->words()));
    }
    if (place->type == RegisterType::bit && words.front() > 1)
      throw Error(ErrorCode::bad_input, where + "/words/0", "a bit is 0 or 1");
    backup.settings.push_back(take_value(*place, std::move(words)));
  }
  backup.unreadable = read["unreadable"].get<std::vector<std::string>>();
  return backup;
}

SettingsBackup load_backup(const std::string& path, const DeviceProfile& profile) {
  return parse_backup(load_json_file(path), profile, path);
}

json describe_change(const SettingChange& change) {
  const auto side = [](const std::optional<SettingValue>& value) {
    return value ? number_or_null(value->value) : json(nullptr);
  };
  return {{"register", change.place->name},
          {"address", change.place->describe_place()},
          {"old", side(change.before)},
          {"new", side(change.after)},
          {"unit", change.place->symbol}};
}

std::string describe_changes(const std::vector<SettingChange>& changes) {
  std::vector<Row> rows{{"register", "address", "old", "new"}};
  for (const SettingChange& change : changes) {
    rows.push_back({change.place->name, change.place->describe_place(),
                    describe_side(change, change.before), describe_side(change, change.after)});
  }
  return align_rows(rows);
}

std::string describe_contents(const std::vector<SettingChange>& contents) {
  std::vector<Row> rows{{"register", "address", "value"}};
  for (const SettingChange& each : contents)
    rows.push_back(
        {each.place->name, each.place->describe_place(), describe_side(each, each.after)});
  return align_rows(rows);
}

std::string describe_device(const LinkAddress& address, int unit) {
  if (const auto* line = std::get_if<SerialAddress>(&address)) {
    return fmt::format("{} unit {}", describe_line(*line, unit), unit);
  }
  TcpAddress tcp = std::get<TcpAddress>(address);
  if (tcp.host == "localhost" || tcp.host == "::1") tcp.host = "127.0.0.1";
  return fmt::format("{} unit {}", describe(LinkAddress(tcp)), unit);
}

std::string describe_line(const LinkAddress& address, int unit) {
  const auto* line = std::get_if<SerialAddress>(&address);
  if (line == nullptr) return describe_device(address, unit);
  std::error_code unknown;
  const auto device = std::filesystem::canonical(line->device, unknown);
  return "rtu://" + (unknown ? line->device : device.string());
}

std::string describe_time_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

}  // namespace gyrator
