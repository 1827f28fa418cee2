#pragma once

#include "gyrator/core/random_stream.hpp"
#include "gyrator/core/rational.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace gyrator {

/// How often an environment behind the fast loop is computed, and how its results come back.
struct SlowUpdate {
  std::optional<Rational> period{};  ///< [s]; none: that of the fast loop
  Rational delay{0};                 ///< [s], from the slow tick to where its result is used
  double loss = 0;                   ///< probability that a result is lost, in [0, 1)
  std::uint64_t seed = 1;            ///< of the losses
};

/// Whether an environment has a rate of its own at all, or results that come late or not at all.
bool has_own_rate(const SlowUpdate& update);

/// Whether it is part of a fast loop of that period [s]: as often, without delay and loss.
bool is_immediate(const SlowUpdate& update, double period);

/// Throws bad_input, at controller/update, for what is not: such a loop has no one H(z).
void require_immediate(const SlowUpdate& update, double period);

/// The ticks of a slow environment, counted in those of the fast loop; exact for ever.
///   slow tick j, at j P, is computed at fast tick        k_j = ceil(j P/T)             (slow-1)
///   its result is used from fast tick                    ceil((j P + D)/T) on          (slow-2)
/// T fast and P slow period, D delay [s]. P need not be a multiple of T (1/60 s behind 1 ms): k_j
/// comes from j, nothing is accumulated. The fast loop comes first: an environment that is slower
/// reads what fast tick k_j has read, and its result is used from tick k_j + 1 on at the earliest.
/// With P = T the environment is part of the loop: without delay its result is used at once.
///
/// A lost result never arrives, the last one that did stays in use; the first is never lost.
/// Throws bad_input, at controller/update, for P < T ("rates that do not nest"), D < 0 and a loss
/// outside [0, 1).
class SlowClock {
 public:
  SlowClock(const SlowUpdate& update, const Rational& fast_period);

  /// Whether the environment is computed at every fast tick.
  bool in_loop() const { return in_loop_; }
  double period() const { return period_; }  ///< P [s]
  /// The most results that can be under way at once.
  std::size_t most_under_way() const { return most_under_way_; }

  /// Goes to the next fast tick, the first of which is tick 0; whether a slow one is due there.
  bool advance() {
    ++fast_;
    if (fast_ < due_) return false;
    due_ = ceiling((++slow_) * period_parts_);
    return true;
  }

  std::int64_t fast_tick() const { return fast_; }

  /// The fast tick from which on the result of the slow tick just met is used; none if it is lost.
  std::optional<std::int64_t> find_arrival();

 private:
  std::int64_t ceiling(std::int64_t parts) const {
    return (parts + parts_per_tick_ - 1) / parts_per_tick_;
  }

  bool in_loop_ = true;
  double period_ = 0;
  // P, D and T in units of their common divisor.
  std::int64_t period_parts_ = 1, delay_parts_ = 0, parts_per_tick_ = 1;
  std::size_t most_under_way_ = 1;
  std::int64_t fast_ = -1, slow_ = 0, due_ = 0;
  double loss_ = 0;
  RandomStream random_;
};

/// What a slow environment tells the fast loop: the newest Values that have arrived.
/// Allocates only when constructed.
template <class Values>
class SlowLink {
 public:
  SlowLink(const SlowUpdate& update, const Rational& fast_period)
      : clock_(update, fast_period), ring_(clock_.most_under_way()) {}

  const SlowClock& clock() const { return clock_; }

  /// One fast tick: `compute` gives the Values of a slow tick that is due.
  /// Returns what the fast loop knows now, and in `arrived` whether that is new.
  template <class Compute>
  const Values& exchange(const Compute& compute) {
    if (clock_.advance()) {
      const Values values = compute();
      if (const auto arrival = clock_.find_arrival()) {
        ring_[(first_ + count_) % ring_.size()] = {*arrival, values};
        ++count_;
      }
    }
    arrived_ = false;
    while (count_ > 0 && ring_[first_].arrival <= clock_.fast_tick()) {
      known_ = ring_[first_].values;
      arrived_ = true;
      first_ = (first_ + 1) % ring_.size();
      --count_;
    }
    return known_;
  }

  bool arrived() const { return arrived_; }
  const Values& known() const { return known_; }
  void start_with(const Values& values) { known_ = values; }

 private:
  struct UnderWay {
    std::int64_t arrival = 0;
    Values values{};
  };

  SlowClock clock_;
  std::vector<UnderWay> ring_;
  std::size_t first_ = 0, count_ = 0;
  Values known_{};
  bool arrived_ = false;
};

}  // namespace gyrator
