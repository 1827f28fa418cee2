#pragma once

#include "gyrator/controllers/sampling.hpp"
#include "gyrator/core/random_stream.hpp"
#include "gyrator/cosim/sampled_plant.hpp"

#include <deque>
#include <optional>

namespace gyrator {

/// The converter between controller and amplifier: rounds the command to the nearest multiple of
/// `quantum`, halves up, then keeps it within ± `limit`.
struct Dac {
  double quantum = 0;             ///< [N, N.m]; 0 for none
  std::optional<double> limit{};  ///< [N, N.m]

  double convert(double command) const;
};

/// When the controller samples: tick k at s_k = k T + J_k, J_k uniform in ± jitter, J_0 = 0.
/// J_k is a multiple of jitter/65536, so that time stays exact.
class SampleClock {
 public:
  SampleClock(const Sampling& sampling, std::uint64_t seed);

  bool jitters() const { return jitter_.num() > 0; }
  /// J_k of the current tick and of the one after [s].
  const Rational& offset() const { return offset_; }
  const Rational& next_offset() const { return next_; }
  /// s_k of tick k [s], correctly rounded while k num(T) is below 2^53 and J_k = 0; each from k
  /// anew, so that nothing accumulates.
  double time_of_tick(std::int64_t k) const;
  double time_of_next(std::int64_t k) const;
  /// s_(k+1) - s_k [s].
  double period() const;
  /// To the next tick.
  void advance();

 private:
  Rational draw();

  Rational nominal_, jitter_, offset_, next_;
  RandomStream random_;
};

/// Converted commands on their way from the sample that they were computed at to the plant.
class CommandPath {
 public:
  /// Throws bad_input for delays of more periods than can be simulated.
  CommandPath(const Sampling& sampling, const SplitDelay& delay);

  /// The command of tick k, sampled at k T + offset, takes effect `delay` later.
  void send(std::int64_t k, const Rational& offset, double command);
  bool empty() const { return under_way_.empty(); }
  /// When the next one takes effect, from k T on [s]; one must be under way.
  Rational next_after_tick(std::int64_t k) const;
  double next_value() const { return under_way_.front().command; }
  /// Whether it takes effect at `offset` after k T.
  bool is_due(std::int64_t k, const Rational& offset) const {
    return !under_way_.empty() && next_after_tick(k) == offset;
  }
  /// Takes it.
  double receive();

 private:
  struct UnderWay {
    std::int64_t tick;  ///< takes effect `offset` after tick · T
    Rational offset;
    double command;
  };
  Rational period_, rest_;
  std::int64_t whole_;
  std::deque<UnderWay> under_way_;
};

}  // namespace gyrator
