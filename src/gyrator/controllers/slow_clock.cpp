#include "gyrator/controllers/slow_clock.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <numeric>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr std::uint64_t loss_stream = 0x105535;  // apart from those of the sample loop
constexpr std::int64_t most_results_under_way = 1'000'000;

void check(const SlowUpdate& update, const Rational& period, const Rational& fast) {
  if (period < fast) {
    throw Error(ErrorCode::bad_input, "controller/update/period",
                fmt::format("{:g} s: rates that do not nest: an environment updates at most as "
                            "often as the fast loop, every {:g} s",
                            period.to_double(), fast.to_double()));
  }
  if (update.delay < 0) {
    throw Error(ErrorCode::bad_input, "controller/update/delay",
                fmt::format("{:g} s: must be at least 0 s", update.delay.to_double()));
  }
  if (!(update.loss >= 0 && update.loss < 1)) {
    throw Error(ErrorCode::bad_input, "controller/update/loss",
                fmt::format("{:g}: must be at least 0 and below 1", update.loss));
  }
  if (update.delay / period > Rational(most_results_under_way)) {
    throw Error(ErrorCode::bad_input, "controller/update/delay",
                fmt::format("{:g} s: at most {} updates can be under way", update.delay.to_double(),
                            most_results_under_way));
  }
}

}  // namespace

bool has_own_rate(const SlowUpdate& update) {
  return update.period || update.delay != Rational(0) || update.loss != 0;
}

bool is_immediate(const SlowUpdate& update, double period) {
  const bool as_often = !update.period || *update.period == Rational::from_double(period);
  return as_often && update.delay == Rational(0) && update.loss == 0;
}

void require_immediate(const SlowUpdate& update, double period) {
  if (is_immediate(update, period)) return;
  const double slow = update.period ? update.period->to_double() : period;
  throw Error(ErrorCode::bad_input, "controller/update",
              fmt::format("every {:g} s behind a loop of {:g} s, {:g} s late, {:g} of it lost: the "
                          "loop then has no one H(z) that a criterion could judge; use simulate, "
                          "or leave \"update\" out to judge it at the loop's own rate",
                          slow, period, update.delay.to_double(), update.loss));
}

SlowClock::SlowClock(const SlowUpdate& update, const Rational& fast_period)
    : loss_(update.loss), random_(update.seed, loss_stream) {
  const Rational period = update.period.value_or(fast_period);
  check(update, period, fast_period);
  in_loop_ = period == fast_period;
  period_ = period.to_double();
  const Rational ticks = period / fast_period;
  const Rational late = update.delay / fast_period;
  // On the common denominator; Rational's multiplication refuses what does not fit.
  const Rational common =
      Rational(ticks.den() / std::gcd(ticks.den(), late.den())) * Rational(late.den());
  parts_per_tick_ = common.num();
  period_parts_ = (ticks * common).num();
  delay_parts_ = (late * common).num();
  most_under_way_ =
      static_cast<std::size_t>(ceil_divide(update.delay + fast_period + fast_period, period)) + 1;
}

std::optional<std::int64_t> SlowClock::find_arrival() {
  const std::int64_t tick = slow_ - 1;  // advance() has gone beyond it
  if (loss_ > 0) {
    const double drawn = random_.uniform();  // at every tick, so that seeds mean the same losses
    if (drawn < loss_ && tick > 0) return std::nullopt;
  }
  const std::int64_t arrival = ceiling(tick * period_parts_ + delay_parts_);
  return in_loop_ ? arrival : std::max(arrival, fast_ + 1);
}

}  // namespace gyrator
