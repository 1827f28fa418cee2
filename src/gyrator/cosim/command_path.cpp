#include "gyrator/cosim/command_path.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/cosim/sensor.hpp"

#include <algorithm>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr std::int64_t most_delay_periods = 10'000'000;
constexpr std::int64_t jitter_steps = 65536;

}  // namespace

double Dac::convert(double command) const {
  const double rounded = round_to_multiple(command, quantum);
  return limit ? std::clamp(rounded, -*limit, *limit) : rounded;
}

SampleClock::SampleClock(const Sampling& sampling, std::uint64_t seed)
    : nominal_(sampling.period), jitter_(sampling.jitter), random_(seed, jitter_stream) {
  if (jitters()) next_ = draw();
}

Rational SampleClock::draw() {
  return jitter_ * Rational(random_.symmetric_integer(jitter_steps), jitter_steps);
}

double SampleClock::time_of_tick(std::int64_t k) const {
  return static_cast<double>(k) * static_cast<double>(nominal_.num()) /
             static_cast<double>(nominal_.den()) +
         offset_.to_double();
}

double SampleClock::time_of_next(std::int64_t k) const {
  return static_cast<double>(k + 1) * static_cast<double>(nominal_.num()) /
             static_cast<double>(nominal_.den()) +
         next_.to_double();
}

double SampleClock::period() const {
  return jitters() ? (nominal_ + next_ - offset_).to_double() : nominal_.to_double();
}

void SampleClock::advance() {
  offset_ = next_;
  if (jitters()) next_ = draw();
}

CommandPath::CommandPath(const Sampling& sampling, const SplitDelay& delay)
    : period_(sampling.period),
      rest_(sampling.delay - Rational(delay.whole) * sampling.period),
      whole_(delay.whole) {
  if (delay.whole <= most_delay_periods) return;
  throw Error(ErrorCode::bad_input, "sampling/delay",
              fmt::format("{} sample periods: at most {} can be simulated", delay.whole,
                          most_delay_periods));
}

void CommandPath::send(std::int64_t k, const Rational& offset, double command) {
  under_way_.push_back({k + whole_, offset.num() == 0 ? rest_ : rest_ + offset, command});
}

Rational CommandPath::next_after_tick(std::int64_t k) const {
  const UnderWay& next = under_way_.front();
  return next.tick == k ? next.offset : next.offset + Rational(next.tick - k) * period_;
}

double CommandPath::receive() {
  const double command = under_way_.front().command;
  under_way_.pop_front();
  return command;
}

}  // namespace gyrator
