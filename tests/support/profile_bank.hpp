#pragma once

#include "gyrator/amplifiers/device_profile.hpp"
#include "gyrator/modbus/modbus_server.hpp"

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace gyrator::amplifier_tests {

/// The registers of a profile in memory, each at its least value: what has no name is an illegal
/// address.
class ProfileBank final : public RegisterBank {
 public:
  explicit ProfileBank(const DeviceProfile& profile) : profile_(profile) {
    for (const DeviceRegister& place : profile.registers)
      for (int i = 0; i < place.words(); ++i) words_[{place.table, place.address + i}] = 0;
    for (const DeviceRegister& place : profile.registers) {
      if (place.low) put(place.name, *place.low);
      if (!place.codes.empty()) put(place.name, static_cast<double>(place.codes[0].second));
    }
    for (const DeviceAction& check : profile.identity) put(check.register_name, check.value);
  }

  double get(const std::string& name) {
    const std::lock_guard lock(mutex_);
    const DeviceRegister& place = profile_.at(name);
    return to_physical(place, take_raw(place, words_of(place))).value_or(-1);
  }
  void put(const std::string& name, double value) {
    const std::lock_guard lock(mutex_);
    const DeviceRegister& place = profile_.at(name);
    const auto words = put_raw(place, to_raw(place, value), words_of(place));
    for (int i = 0; i < place.words(); ++i)
      words_.at({place.table, place.address + i}) = words[static_cast<std::size_t>(i)];
  }
  std::map<std::pair<RegisterTable, int>, std::uint16_t> content() {
    const std::lock_guard lock(mutex_);
    return words_;
  }

  /// Addresses that ignore what is written to them, and that are refused.
  std::set<int> stuck, refused;
  std::atomic<int> reads{0}, writes{0};
  std::vector<int> written;  ///< addresses, in order

  /// What the buffer of a capture holds once it was armed and started, by signal [SI].
  std::map<CaptureSignal, std::vector<double>> samples;
  /// Called when a capture is done, with the drive on or off.
  std::function<void(bool enabled)> when_done;

  Answer<std::vector<bool>> read_bits(RegisterTable table, int address, int count) override {
    const auto words = read(table, address, count);
    if (!words) return ModbusException::illegal_data_address;
    return std::vector<bool>(words->begin(), words->end());
  }
  Answer<std::vector<std::uint16_t>> read_registers(RegisterTable table, int address,
                                                    int count) override {
    const auto words = read(table, address, count);
    if (!words) return ModbusException::illegal_data_address;
    return *words;
  }
  std::optional<ModbusException> write_coils(int address,
                                             const std::vector<bool>& values) override {
    return write(RegisterTable::coil, address, {values.begin(), values.end()});
  }
  std::optional<ModbusException> write_registers(int address,
                                                 std::span<const std::uint16_t> words) override {
    return write(RegisterTable::holding, address, {words.begin(), words.end()});
  }

 private:
  std::vector<std::uint16_t> words_of(const DeviceRegister& place) const {
    std::vector<std::uint16_t> words;
    for (int i = 0; i < place.words(); ++i)
      words.push_back(words_.at({place.table, place.address + i}));  // of a window: its first
    return words;
  }
  void set(const DeviceRegister& place, int address, double value) {
    const auto words = put_raw(place, to_raw(place, value), words_of(place));
    for (int i = 0; i < place.words(); ++i)
      words_[{place.table, address + i}] = words[static_cast<std::size_t>(i)];
  }
  double value_of(const std::string& name) const {
    const DeviceRegister& place = profile_.at(name);
    return to_physical(place, take_raw(place, words_of(place))).value_or(-1);
  }
  // What the generator and the buffer do with what was written.
  void act() {
    if (!profile_.capture || samples.empty()) return;
    const DeviceCapture& capture = *profile_.capture;
    const auto is_set = [&](const DeviceAction& action) {
      return value_of(action.register_name) == action.value;
    };
    if (is_set(capture.arm) && is_set(profile_.excitation->start)) {
      const DeviceRegister& state = profile_.at(capture.state);
      set(state, state.address, static_cast<double>(*find_code(state, "done")));
      if (when_done) when_done(value_of("enable") != 0);
      for (const DeviceAction& action : {capture.arm, profile_.excitation->start}) {
        const DeviceRegister& place = profile_.at(action.register_name);
        set(place, place.address, 0);
      }
    }
    const int page = capture.page.empty() ? 0 : static_cast<int>(value_of(capture.page));
    const int shown = capture.page.empty() ? capture.max_samples : capture.page_samples;
    for (const auto& [signal, first] : capture.signals) {
      for (int i = 0; i < shown; ++i) {
        const auto at = static_cast<std::size_t>(page * shown + i);
        for (int word = 0; word < first.words(); ++word)
          words_.try_emplace({first.table, first.address + i * first.words() + word}, 0);
        if (at < samples[signal].size())
          set(first, first.address + i * first.words(), samples[signal][at]);
      }
    }
  }
  std::optional<std::vector<std::uint16_t>> read(RegisterTable table, int address, int count) {
    const std::lock_guard lock(mutex_);
    ++reads;
    std::vector<std::uint16_t> words;
    for (int i = 0; i < count; ++i) {
      const auto found = words_.find({table, address + i});
      if (found == words_.end() || refused.contains(address + i)) return {};
      words.push_back(found->second);
    }
    return words;
  }
  std::optional<ModbusException> write(RegisterTable table, int address,
                                       const std::vector<std::uint16_t>& words) {
    const std::lock_guard lock(mutex_);
    ++writes;
    written.push_back(address);
    for (std::size_t i = 0; i < words.size(); ++i) {
      const int at = address + static_cast<int>(i);
      if (!words_.contains({table, at})) return ModbusException::illegal_data_address;
      if (!stuck.contains(at)) words_[{table, at}] = words[i];
    }
    act();
    return {};
  }

  const DeviceProfile& profile_;
  std::mutex mutex_;
  std::map<std::pair<RegisterTable, int>, std::uint16_t> words_;
};

/// Such a bank, served on a free port of the loopback by a thread.
class ServedProfile {
 public:
  explicit ServedProfile(const std::string& name, ServerHooks hooks = {})
      : profile(load_device_profile(name)),
        bank(profile),
        server_(bank, {.unit = profile.link.unit}, std::move(hooks)),
        port_(server_.listen("127.0.0.1", 0)),
        thread_([this] { server_.run(); }) {}
  ~ServedProfile() { stop(); }
  ServedProfile(const ServedProfile&) = delete;
  ServedProfile& operator=(const ServedProfile&) = delete;

  void stop() {
    server_.stop();
    if (thread_.joinable()) thread_.join();
  }
  LinkAddress address() const { return TcpAddress{"127.0.0.1", port_}; }

  DeviceProfile profile;
  ProfileBank bank;

 private:
  ModbusServer server_;
  std::uint16_t port_;
  std::thread thread_;
};

}  // namespace gyrator::amplifier_tests
