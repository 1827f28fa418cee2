// A Modbus device, or a client, for tests that bring in programs of others.
//   modbus_tool serve tcp                  prints "listening PORT"
//   modbus_tool serve rtu LINK             prints "listening LINK"
// serves the tables of counting_bank.hpp until its standard input ends, then prints
// "reads N writes N".
//   modbus_tool ask ADDRESS [TIMEOUT_S [RETRIES [LOG]]]
// does what the lines of its standard input say, and answers each with "ok WORDS" or
// "FAULT MESSAGE", FAULT being refused, timeout, lost, garbled, exception or bad:
//   input|holding|coil|discrete ADDRESS COUNT      reads
//   write ADDRESS WORDS, set COIL 0|1, sets COIL BITS
//   statistics
#include "gyrator/core/error.hpp"
#include "gyrator/modbus/modbus_link.hpp"
#include "gyrator/modbus/modbus_server.hpp"

#include <array>
#include <iostream>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>

#include "support/counting_bank.hpp"

using namespace gyrator;

namespace {

int serve(const std::vector<std::string>& words) {
  modbus_tests::CountingBank bank;
  ModbusServer server(bank);
  if (words.at(1) == "tcp") {
    std::cout << "listening " << server.listen("127.0.0.1", 0) << std::endl;
  } else {
    server.open_pseudo_terminal(words.at(2), {});
    std::cout << "listening " << words.at(2) << std::endl;
  }
  std::thread watch([&] {
    std::string line;
    while (std::getline(std::cin, line)) {
    }
    server.stop();
  });
  server.run();
  watch.join();
  std::cout << "reads " << bank.reads << " writes " << bank.writes << std::endl;
  return 0;
}

template <class Values>
std::string list(const Values& values) {
  std::string text;
  for (const auto value : values) text += " " + std::to_string(static_cast<int>(value));
  return text;
}

std::string perform(ModbusLink& link, std::istringstream& line) {
  std::string verb;
  line >> verb;
  if (verb == "statistics") {
    const LinkStatistics s = link.statistics();
    return list(std::array{s.requests, s.writes, s.retries, s.reconnects});
  }
  int address = 0;
  line >> address;
  const std::vector<int> values{std::istream_iterator<int>(line), {}};
  if (const auto table = find_register_table(verb)) {
    if (holds_bits(*table)) return list(link.read_bits(*table, address, values.at(0)));
    return list(link.read_registers(*table, address, values.at(0)));
  }
  if (verb == "write")
    link.write_registers(address, std::vector<std::uint16_t>(values.begin(), values.end()));
  else if (verb == "set")
    link.write_coil(address, values.at(0) != 0);
  else if (verb == "sets")
    link.write_coils(address, std::vector<bool>(values.begin(), values.end()));
  else
    throw Error(ErrorCode::bad_input, verb, "no such verb");
  return "";
}

const char* name_of_fault(LinkFault fault) {
  switch (fault) {
    case LinkFault::refused:
      return "refused";
    case LinkFault::timeout:
      return "timeout";
    case LinkFault::lost:
      return "lost";
    case LinkFault::garbled:
      return "garbled";
    case LinkFault::exception:
      break;
  }
  return "exception";
}

int ask(const std::vector<std::string>& words) {
  LinkOptions options;
  if (words.size() > 2) options.response_timeout = std::stod(words[2]);
  if (words.size() > 3) options.read_retries = std::stoi(words[3]);
  if (words.size() > 4) options.wire_log = words[4];
  ModbusLink link(parse_link_address(words.at(1)), options);
  std::string text;
  while (std::getline(std::cin, text)) {
    std::istringstream line(text);
    try {
      const std::string answer = perform(link, line);
      std::cout << "ok" << answer << std::endl;
    } catch (const LinkError& error) {
      std::cout << name_of_fault(error.fault()) << ' ' << error.what() << std::endl;
    } catch (const Error& error) {
      std::cout << "bad " << error.what() << std::endl;
    }
  }
  return 0;
}

}  // namespace

int main(int count, char** texts) {
  const std::vector<std::string> words(texts + 1, texts + count);
  try {
    return words.at(0) == "serve" ? serve(words) : ask(words);
  } catch (const std::exception& error) {
    std::cout << "failed " << error.what() << std::endl;
    return 1;
  }
}
