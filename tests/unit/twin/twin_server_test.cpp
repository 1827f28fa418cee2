#include "gyrator/twin/twin_server.hpp"

#include "gyrator/core/error.hpp"

#include <array>
#include <string>

#include <gtest/gtest.h>

#include "unit/twin/twin_models.hpp"

namespace gyrator {
namespace {

constexpr std::array<std::uint8_t, 5> read_request{4, 0, 0, 0, 2};
constexpr std::array<std::uint8_t, 6> read_answer{4, 4, 1, 2, 3, 4};
constexpr std::array<std::uint8_t, 5> write_request{6, 0, 40, 0, 1};

struct Twin {
  explicit Twin(std::optional<double> pace = std::nullopt)
      : profile(load_device_profile("gyrator_twin")),
        amplifier(make_plain_twin()),
        bank(amplifier, profile, {pace, ""}) {}
  DeviceProfile profile;
  SimulatedAmplifier amplifier;
  TwinBank bank;
};

TEST(TwinMoods, AreReadByName) {
  TwinMoods expected;
  expected.busy = 0.01;
  expected.late = 0.02;
  expected.late_by = 0.8;
  expected.stuck = "current_limit";
  EXPECT_EQ(parse_twin_moods("busy=0.01, late=2 %:800ms,stuck=current_limit"), expected);
  EXPECT_EQ(parse_twin_moods(""), TwinMoods{});
}

TEST(TwinMoods, SlipsAreNamed) {
  const auto message_of = [](const char* text) -> std::string {
    try {
      parse_twin_moods(text);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message_of("bussy=0.1").find("did you mean 'busy'"), std::string::npos);
  EXPECT_NE(message_of("busy=1.1").find("between 0 and 1"), std::string::npos);
  EXPECT_NE(message_of("busy=x").find("between 0 and 1"), std::string::npos);
  EXPECT_NE(message_of("busy").find("NAME=PROBABILITY"), std::string::npos);
  EXPECT_NE(message_of("late=0.1:3V").find("time"), std::string::npos);
}

TEST(TwinHooks, WithoutAPaceTheDevicesTimePassesByTheWire) {
  Twin twin;
  TwinTiming timing;
  timing.wire = SerialAddress{"", 9600, Parity::even, 1};
  timing.turnaround = 2e-3;
  const ServerHooks hooks = make_twin_hooks(twin.bank, timing, {}, 1);
  const AnswerPlan plan = hooks.before_answer({read_request, read_answer, 8, 9});
  EXPECT_EQ(plan.delay, 0);
  // 17 characters of 11 bits and two silences of 3.5 characters.
  const double time = (17 + 7) * 11 / 9600.0 + 2e-3;
  EXPECT_NEAR(twin.amplifier.time(), time, SimulatedAmplifier::tick);
}

TEST(TwinHooks, WithAPaceTheAnswerWaits) {
  Twin twin(2.0);
  TwinTiming timing;
  timing.turnaround = 10e-3;
  timing.pace = 2.0;
  const ServerHooks hooks = make_twin_hooks(twin.bank, timing, {}, 1);
  EXPECT_DOUBLE_EQ(hooks.before_answer({read_request, read_answer, 8, 9}).delay, 5e-3);
}

TEST(TwinHooks, EachMoodComesAsOftenAsAsked) {
  const auto count = [](const TwinMoods& moods, const auto& shows) {
    Twin twin;
    const ServerHooks hooks = make_twin_hooks(twin.bank, {}, moods, 7);
    int times = 0;
    for (int k = 0; k < 2000; ++k) times += shows(hooks) ? 1 : 0;
    return times;
  };
  // 2000 draws at 1/4: 500, standard deviation 19.4; four of them.
  constexpr double expected = 500, spread = 78;
  const auto fate = [](AnswerPlan::Fate wanted) {
    return [wanted](const ServerHooks& hooks) {
      return hooks.before_answer({read_request, read_answer, 8, 9}).fate == wanted;
    };
  };
  using Fate = AnswerPlan::Fate;
  TwinMoods moods;
  const auto at = [](double TwinMoods::*mood) {
    TwinMoods one;
    one.*mood = 0.25;
    return one;
  };
  EXPECT_NEAR(count(at(&TwinMoods::drop), fate(Fate::cut)), expected, spread);
  EXPECT_NEAR(count(at(&TwinMoods::silent), fate(Fate::swallow)), expected, spread);
  EXPECT_NEAR(count(at(&TwinMoods::garble), fate(Fate::garble)), expected, spread);
  EXPECT_NEAR(count(at(&TwinMoods::half), fate(Fate::halve)), expected, spread);
  EXPECT_NEAR(count(at(&TwinMoods::busy),
                    [](const ServerHooks& hooks) {
                      return hooks.before_request(read_request) == ModbusException::device_busy;
                    }),
              expected, spread);
  EXPECT_NEAR(count(at(&TwinMoods::late),
                    [](const ServerHooks& hooks) {
                      return hooks.before_answer({read_request, read_answer, 8, 9}).delay == 1;
                    }),
              expected, spread);
  // Only the answer to a write is an echo.
  const auto is_other = [](const auto& answer) {
    return [&answer](const ServerHooks& hooks) {
      return hooks.before_answer({write_request, answer, 8, 8}).other_answer.has_value();
    };
  };
  EXPECT_NEAR(count(at(&TwinMoods::echo), is_other(write_request)), expected, spread);
  EXPECT_EQ(count(at(&TwinMoods::echo), is_other(read_answer)), 0);
  EXPECT_EQ(count(moods, fate(Fate::send)), 2000);
}

}  // namespace
}  // namespace gyrator
