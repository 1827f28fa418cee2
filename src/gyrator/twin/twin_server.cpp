#include "gyrator/twin/twin_server.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/quantity.hpp"
#include "gyrator/core/text.hpp"

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr const char* place = "misbehave";
constexpr std::uint64_t mood_stream = 21;

struct Mood {
  std::string_view name;
  double TwinMoods::*probability;
};
constexpr std::array moods_by_name{
    Mood{"busy", &TwinMoods::busy},     Mood{"late", &TwinMoods::late},
    Mood{"drop", &TwinMoods::drop},     Mood{"silent", &TwinMoods::silent},
    Mood{"garble", &TwinMoods::garble}, Mood{"half", &TwinMoods::half},
    Mood{"echo", &TwinMoods::echo},
};

double parse_probability(std::string_view name, std::string_view text) {
  const auto refuse = [&] {
    throw Error(ErrorCode::bad_input, place,
                fmt::format("{}={}: must be a probability between 0 and 1", name, text));
  };
  double value = 0;
  try {
    value = parse_value(text, dimension::none);
  } catch (const Error&) {
    refuse();
  }
  if (!(value >= 0 && value <= 1)) refuse();
  return value;
}

void parse_mood(TwinMoods& moods, std::string_view item) {
  const std::size_t equals = item.find('=');
  const std::string name(trim(item.substr(0, equals)));
  if (equals == std::string_view::npos) {
    throw Error(ErrorCode::bad_input, place,
                fmt::format("'{}': expected NAME=PROBABILITY, as busy=0.01", item));
  }
  std::string_view value = trim(item.substr(equals + 1));
  if (name == "stuck") {
    moods.stuck = value;
    return;
  }
  for (const Mood& mood : moods_by_name) {
    if (mood.name != name) continue;
    const std::size_t colon = value.find(':');
    if (name == "late" && colon != std::string_view::npos) {
      moods.late_by = parse_value(value.substr(colon + 1), dimension::time);
      value = value.substr(0, colon);
    }
    moods.*mood.probability = parse_probability(name, value);
    return;
  }
  std::vector<std::string> known{"stuck"};
  for (const Mood& mood : moods_by_name) known.emplace_back(mood.name);
  throw Error(ErrorCode::bad_input, place, describe_unknown_name("misbehaviour", name, known));
}

bool is_write(std::span<const std::uint8_t> pdu) {
  return pdu.size() > 2 && (pdu[0] == 5 || pdu[0] == 6 || pdu[0] == 15 || pdu[0] == 16);
}

// The hooks' shared state, as long as either of them lives.
class Behaviour {
 public:
  Behaviour(TwinBank& bank, const TwinTiming& timing, TwinMoods moods, std::uint64_t seed)
      : bank_(bank), timing_(timing), moods_(std::move(moods)), random_(seed, mood_stream) {}

  std::optional<ModbusException> before_request() {
    bank_.keep_pace();
    if (happens(moods_.busy)) return ModbusException::device_busy;
    return std::nullopt;
  }

  AnswerPlan before_answer(const ServerExchange& exchange) {
    AnswerPlan plan;
    double time = timing_.turnaround;
    if (timing_.wire)
      time += compute_wire_time(*timing_.wire, exchange.request_bytes, exchange.answer_bytes);
    bank_.pass(time);
    if (timing_.pace) plan.delay = time / *timing_.pace;
    if (happens(moods_.late)) plan.delay += moods_.late_by;
    using Fate = AnswerPlan::Fate;
    for (const auto& [probability, fate] :
         {std::pair(moods_.drop, Fate::cut), std::pair(moods_.silent, Fate::swallow),
          std::pair(moods_.garble, Fate::garble), std::pair(moods_.half, Fate::halve)})
      if (happens(probability)) plan.fate = fate;
    if (is_write(exchange.answer) && happens(moods_.echo)) {
      plan.other_answer.emplace(exchange.answer.begin(), exchange.answer.end());
      (*plan.other_answer)[2] ^= 1U;  // the lower byte of the address
    }
    return plan;
  }

 private:
  bool happens(double probability) { return probability > 0 && random_.uniform() < probability; }

  TwinBank& bank_;
  TwinTiming timing_;
  TwinMoods moods_;
  RandomStream random_;
};

}  // namespace

TwinMoods parse_twin_moods(std::string_view text) {
  TwinMoods moods;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    parse_mood(moods, trim(text.substr(0, comma)));
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  return moods;
}

ServerHooks make_twin_hooks(TwinBank& bank, const TwinTiming& timing, const TwinMoods& moods,
                            std::uint64_t seed) {
  const auto behaviour = std::make_shared<Behaviour>(bank, timing, moods, seed);
  return {
      [behaviour](std::span<const std::uint8_t>) { return behaviour->before_request(); },
      [behaviour](const ServerExchange& exchange) { return behaviour->before_answer(exchange); }};
}

}  // namespace gyrator
