#include "gyrator/modbus/modbus_link.hpp"

#include "gyrator/core/text.hpp"
#include "gyrator/modbus/link_connection.hpp"
#include "gyrator/modbus/modbus_frame.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/core.h>

namespace gyrator {
namespace {

void check(bool fine, const std::string& place, const std::string& message) {
  if (!fine) throw Error(ErrorCode::bad_input, place, message);
}

void check_options(const std::string& place, const LinkAddress& address,
                   const LinkOptions& options) {
  constexpr int last_unit = 247;
  constexpr int tcp_device = 255;
  constexpr double longest_time = 3600;  // [s]
  const bool tcp = std::holds_alternative<TcpAddress>(address);
  check((options.unit >= 1 && options.unit <= last_unit) ||
            (tcp && (options.unit == 0 || options.unit == tcp_device)),
        place,
        fmt::format("unit {}: must be from 1 to {}{}", options.unit, last_unit,
                    tcp ? ", or over TCP 0 or 255 for the device itself" : ""));
  const auto check_time = [&](std::string_view name, double value, bool positive) {
    check(value <= longest_time && (positive ? value > 0 : value >= 0), place,
          fmt::format("{} of {} s: must be {} 0 and at most {} s", name, value,
                      positive ? "above" : "at least", longest_time));
  };
  check_time("response timeout", options.response_timeout, true);
  check_time("byte timeout", options.byte_timeout, true);
  check_time("gap", options.gap, false);
  check_time("back-off", options.backoff, false);
  const auto check_count = [&](std::string_view name, int value, int lowest, int highest) {
    check(value >= lowest && value <= highest, place,
          fmt::format("{} of {}: must be from {} to {}", name, value, lowest, highest));
  };
  constexpr int most_retries = 1000;
  check_count("number of read retries", options.read_retries, 0, most_retries);
  check_count("most registers in a read", options.max_read, 1, most_read_registers);
  check_count("most registers in a write", options.max_write, 1, most_written_registers);
}

void check_range(const LinkConnection& connection, RegisterTable table, int start,
                 std::size_t count) {
  const bool fits = start >= 0 && start < register_count && count >= 1 &&
                    count <= static_cast<std::size_t>(register_count - start);
  check(fits, connection.name(),
        fmt::format("{} of table {} from {}: it has the addresses 0 to {}", count, name_of(table),
                    start, register_count - 1));
}

Bytes perform(LinkConnection& connection, Bytes pdu, RegisterTable table, int start,
              bool is_write) {
  return connection.perform(
      {std::move(pdu), fmt::format("{}, {}", connection.name(), describe_address(table, start)),
       is_write});
}

LinkOptions checked(const LinkAddress& address, LinkOptions options) {
  check_options(describe(address), address, options);
  return options;
}

}  // namespace

ModbusLink::ModbusLink(LinkAddress address, LinkOptions options) {
  LinkOptions fine = checked(address, std::move(options));
  connection_ = std::make_unique<LinkConnection>(std::move(address), std::move(fine));
}
ModbusLink::~ModbusLink() = default;
ModbusLink::ModbusLink(ModbusLink&&) noexcept = default;
ModbusLink& ModbusLink::operator=(ModbusLink&&) noexcept = default;

std::vector<bool> ModbusLink::read_bits(RegisterTable table, int address, int count) {
  check(holds_bits(table), std::string(name_of(table)), "holds registers: no bits can be read");
  check_range(*connection_, table, address, static_cast<std::size_t>(std::max(count, 0)));
  std::vector<bool> bits;
  for (int done = 0; done < count;) {
    const int start = address + done;
    const int part = std::min(count - done, most_read_bits);
    const Bytes answer =
        perform(*connection_, make_read_request(table, start, part), table, start, false);
    const auto read = read_bit_field(ByteSpan(answer).subspan(2), static_cast<std::size_t>(part));
    bits.insert(bits.end(), read.begin(), read.end());
    done += part;
  }
  return bits;
}

std::vector<std::uint16_t> ModbusLink::read_registers(RegisterTable table, int address, int count) {
  check(!holds_bits(table), std::string(name_of(table)), "holds bits: no registers can be read");
  check_range(*connection_, table, address, static_cast<std::size_t>(std::max(count, 0)));
  std::vector<std::uint16_t> words;
  for (int done = 0; done < count;) {
    const int start = address + done;
    const int part = std::min(count - done, options().max_read);
    const Bytes answer =
        perform(*connection_, make_read_request(table, start, part), table, start, false);
    for (std::size_t at = 2; at < answer.size(); at += 2) words.push_back(read_word(answer, at));
    done += part;
  }
  return words;
}

void ModbusLink::write_coil(int address, bool value) {
  constexpr RegisterTable table = RegisterTable::coil;
  check_range(*connection_, table, address, 1);
  perform(*connection_, make_coil_request(address, value), table, address, true);
}

void ModbusLink::write_coils(int address, const std::vector<bool>& values) {
  constexpr RegisterTable table = RegisterTable::coil;
  check_range(*connection_, table, address, values.size());
  check(values.size() <= most_written_bits, connection_->name(),
        fmt::format("{} coils in a write: at most {}", values.size(), most_written_bits));
  perform(*connection_, make_coils_request(address, values), table, address, true);
}

void ModbusLink::write_registers(int address, std::span<const std::uint16_t> words) {
  constexpr RegisterTable table = RegisterTable::holding;
  check_range(*connection_, table, address, words.size());
  check(words.size() <= static_cast<std::size_t>(options().max_write), connection_->name(),
        fmt::format("{} registers in a write: the device takes at most {}", words.size(),
                    options().max_write));
  const bool single = words.size() == 1 && options().single_register_writes;
  perform(*connection_,
          single ? make_register_request(address, words.front())
                 : make_registers_request(address, words),
          table, address, true);
}

void ModbusLink::reconnect() {
  connection_->reopen();
}
void ModbusLink::disconnect() {
  connection_->close();
}

const LinkAddress& ModbusLink::address() const {
  return connection_->address();
}
const LinkOptions& ModbusLink::options() const {
  return connection_->options();
}
LinkStatistics ModbusLink::statistics() const {
  return connection_->statistics();
}

}  // namespace gyrator
