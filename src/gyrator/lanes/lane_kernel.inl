// The sampled loop of many designs at once. Compiled once per instruction set, into the namespace
// that LANE_NAMESPACE names; includes nothing whose inline functions could be taken for those of
// another instruction set.

#include "gyrator/lanes/lane_program.hpp"
#include "gyrator/lanes/lane_vector.hpp"

namespace gyrator::LANE_NAMESPACE {
namespace {

constexpr int groups = lanes_per_block / vector_width;
constexpr int most_states = 64;  // of a size that is not fixed at compile time

// Sizes that are not fixed at compile time, and the law whose state is the last sample, with one
// gain on either: the wall of every textbook.
constexpr int any_size = -1;
constexpr int last_sample = -2;

// One vector of lanes through one sample, in the order of every run (cosim/simulation.hpp): sample,
// compute, convert, apply. `States` and `LawStates` are -1 where they are not fixed.
template <int States, int LawStates, bool Shared>
class Block {
  // Vectors that go through a step at once: with a plant that all lanes share, a coefficient is
  // read once for them all. There are always two such units or more, for one to compute its
  // commands while the other moves.
  static constexpr int together = Shared && groups >= 4 ? 2 : 1;
  static constexpr int units = groups / together;

 public:
  Block(const LaneProgram& program, const LaneCoefficients& coefficients, const LaneState& state,
        const LaneTraces& traces)
      : p_(program),
        c_(coefficients),
        s_(state),
        t_(traces),
        n_(States == any_size ? program.states : States),
        m_(LawStates == any_size      ? program.law_states
           : LawStates == last_sample ? 1
                                      : LawStates),
        plain_(is_plain()) {}

  void run() {
    [[maybe_unused]] const FlushTinyNumbers flush;
    for (int lane = 0; lane < lanes_per_block; ++lane) {
      t_.end[lane] = LaneEnd::ran_through;
      t_.rows[lane] = p_.samples + 1;
    }
    Rows rows{t_.position, t_.velocity};
    if (t_.low) clear_ranges();
    long k = 0;
    while (k < p_.samples) {
      // Looks come after steps 0, 16, 32 …
      const long stop = k == 0 ? 1 : k + samples_between_looks;
      const bool look = stop <= p_.samples;
      const long from = k;
      advance(k, look ? stop : p_.samples, rows);
      k = look ? stop : p_.samples;
      if (t_.low) extend_ranges(from, k);
      if (look && !go_on(k)) return;
    }
    for (int lane = 0; lane < lanes_per_block; lane += vector_width) record(rows, lane);
    if (t_.low) extend_ranges(k, k + 1);
  }

 private:
  struct Rows {
    double* position;
    double* velocity;
  };

  void clear_ranges() const {
    for (int i = 0; i < lane_stretches * lanes_per_block; ++i) {
      t_.low[i] = __builtin_inf();
      t_.high[i] = -__builtin_inf();
    }
  }

  // By rows [from, to), which have just been written.
  void extend_ranges(long from, long to) const {
    const auto extend = [&](LaneStretch stretch, const double* row, long begin, long end) {
      begin = begin > from ? begin : from;
      end = end < to ? end : to;
      const int at = static_cast<int>(stretch) * lanes_per_block;
      for (int lane = 0; lane < lanes_per_block && begin < end; lane += vector_width) {
        Vector low = load(t_.low + at + lane);
        Vector high = load(t_.high + at + lane);
        for (long k = begin; k < end; ++k) {
          const Vector value = load(row + k * lanes_per_block + lane);
          low = smaller(value, low);
          high = larger(value, high);
        }
        store(t_.low + at + lane, low);
        store(t_.high + at + lane, high);
      }
    };
    const long end = p_.samples + 1;
    extend(LaneStretch::early, t_.velocity, 0, p_.last_third);
    extend(LaneStretch::before_last, t_.velocity, p_.last_third, p_.last_sixth);
    extend(LaneStretch::last, t_.velocity, p_.last_sixth, end);
    extend(LaneStretch::position, t_.position - p_.first_position * lanes_per_block, p_.last_third,
           end);
  }

  int size() const { return States == any_size ? n_ : States; }
  int law_size() const { return LawStates == any_size ? m_ : LawStates; }

  Vector signal(int coordinate, int row, int lane) const {
    if (coordinate >= 0) return load(s_.xi + coordinate * lanes_per_block + lane);
    const int n = size();
    const double* of = c_.signals + row * n * lanes_per_block + lane;
    Vector sum = load(of) * load(s_.xi + lane);
    for (int i = 1; i < n; ++i)
      sum = multiply_add(load(of + i * lanes_per_block), load(s_.xi + i * lanes_per_block + lane),
                         sum);
    return sum;
  }

  void record(const Rows& rows, int lane) const {
    store(rows.position + lane, signal(p_.position, 1, lane));
    store(rows.velocity + lane, signal(p_.velocity, 2, lane));
  }

  static Vector quantize(Vector v, Vector quantum) {
    return quantum * round_down(v / quantum + broadcast(0.5));
  }

  // What the lanes have in common, kept out of the loops by hand: for all the compiler knows, every
  // store could change it.
  struct Common {
    double *xi, *law_state, *commands;
    const double *propagate, *law, *at_position, *at_velocity;
    bool quantized, converts, split;
    Vector quantum, offset, dac_quantum, limit, threshold, most;
  };

  Common make_common() const {
    return {s_.xi,
            s_.law,
            s_.commands,
            c_.propagate,
            c_.law,
            s_.xi + p_.position * lanes_per_block,
            s_.xi + p_.velocity * lanes_per_block,
            p_.quantum > 0,
            p_.dac_quantum > 0,
            p_.split,
            broadcast(p_.quantum),
            broadcast(p_.offset),
            broadcast(p_.dac_quantum),
            broadcast(p_.dac_limit),
            broadcast(p_.contact_threshold),
            broadcast(p_.most_command)};
  }

  // The position is sensed as it is or quantized, and the command acts at once as it is.
  bool is_plain() const {
    const bool delayed = p_.split || p_.whole_delay > 0;
    return p_.sensed >= 0 && p_.position == p_.sensed && p_.velocity >= 0 && !delayed &&
           !p_.noise && p_.offset == 0 && p_.dac_quantum <= 0 && p_.dac_limit > 1.7e308;
  }

  // Steps k up to `stop`.
  void advance(long k, long stop, Rows& rows) const {
    bool plain = plain_;
    for (long i = k; i < stop; ++i) plain = plain && p_.effort[i] == 0;
    if (!plain) {
      for (const Common common = make_common(); k < stop; ++k) {
        step(k, rows, common);
        if (k >= p_.first_position) rows.position += lanes_per_block;
        rows.velocity += lanes_per_block;
      }
      return;
    }
    advance_plain(k, stop, rows);
  }

  // The same for a plain program while nobody pushes. A command is a chain of operations, each
  // waiting for the one before; a unit's is computed while the unit before moves on.
  [[gnu::noinline]] void advance_plain(long k, long stop, Rows& rows) const {
    const Common common = make_common();
    double* position = rows.position;
    double* velocity = rows.velocity;
    const long first_position = p_.first_position;
    Vector commands[groups] = {};
    const auto move = [&](int unit) __attribute__((always_inline)) {
      propagate<true>(common, unit * together * vector_width, nullptr, commands + unit * together,
                      Vector{});
    };
    for (const long first = k; k < stop; ++k) {
#pragma GCC unroll 8
      for (int unit = 0; unit < units; ++unit) {
#pragma GCC unroll 2
        for (int v = unit * together; v < (unit + 1) * together; ++v) {
          const int lane = v * vector_width;
          Vector y = load(common.at_position + lane);
          store(position + lane, y);
          store(velocity + lane, load(common.at_velocity + lane));
          if (common.quantized) y = quantize(y, common.quantum);
          commands[v] = compute(y, common, lane);
        }
        if (unit > 0) {
          move(unit - 1);
        } else if (k > first) {
          move(units - 1);
        }
      }
      if (k >= first_position) position += lanes_per_block;
      velocity += lanes_per_block;
    }
    move(units - 1);
    rows = {position, velocity};
  }

  // All lanes through sample k.
  void step(long k, const Rows& rows, const Common& common) const {
    // Commands under way: slot k mod (m + 2) takes the one of sample k.
    const long slots = p_.whole_delay + 2;
    double* const sent = common.commands + k % slots * lanes_per_block;
    const double* const before = common.commands + (k + 1) % slots * lanes_per_block;
    const double* const arrived = common.commands + (k + 2) % slots * lanes_per_block;
    const Vector noise = broadcast(p_.noise ? p_.noise[k] : 0);
    const Vector effort = broadcast(p_.effort[k]);
    Vector commands[groups], held[groups];
    for (int v = 0; v < groups; ++v) {
      const int lane = v * vector_width;
      record(rows, lane);
      Vector y = signal(p_.sensed, 0, lane) + noise;
      if (common.quantized) y = quantize(y, common.quantum);
      y += common.offset;
      Vector command = compute(y, common, lane);
      if (common.converts) command = quantize(command, common.dac_quantum);
      command = smaller(larger(command, -common.limit), common.limit);
      store(sent + lane, command);
      // With slots for a whole number of periods and one more, the command of k - m.
      commands[v] = p_.whole_delay > 0 ? load(arrived + lane) : command;
      held[v] = common.split ? load(before + lane) : Vector{};
    }
    for (int v = 0; v < groups; v += together)
      propagate<false>(common, v * vector_width, held + v, commands + v, effort);
  }

  // Command of the law, and its state one sample on.
  [[gnu::always_inline]] inline Vector compute(Vector y, const Common& common, int lane) const {
    const double* row = common.law + lane;
    const auto restrict = [&](Vector command) {
      return keep_where(y > common.threshold, smaller(command, common.most));
    };
    if constexpr (LawStates == last_sample) {
      double* const last = common.law_state + lane;
      const Vector command = multiply_add(load(row + 2 * lanes_per_block), load(last),
                                          load(row + 3 * lanes_per_block) * y);
      store(last, y);
      return restrict(command);
    }
    const int m = law_size();
    Vector q[LawStates >= 0 ? LawStates + 1 : most_states];
    for (int j = 0; j < m; ++j) q[j] = load(common.law_state + j * lanes_per_block + lane);
    const auto apply = [&](int i) {
      const double* entry = row + i * (m + 1) * lanes_per_block;
      Vector sum = load(entry + m * lanes_per_block) * y;
      for (int j = 0; j < m; ++j) sum = multiply_add(load(entry + j * lanes_per_block), q[j], sum);
      return sum;
    };
    for (int i = 0; i < m; ++i) store(common.law_state + i * lanes_per_block + lane, apply(i));
    return restrict(apply(m));
  }

  // A unit's vectors, from `lane` on.
  template <bool Plain>
  [[gnu::always_inline]] inline void propagate(const Common& common, int lane, const Vector* before,
                                               const Vector* applied, Vector effort) const {
    const int n = size();
    Vector xi[together][States > 0 ? States : most_states];
    for (int v = 0; v < together; ++v) {
      for (int i = 0; i < n; ++i)
        xi[v][i] = load(common.xi + i * lanes_per_block + lane + v * vector_width);
    }
    constexpr int stride = Shared ? 1 : lanes_per_block;
    // Positions come last: the next command waits for them.
    for (int i = n - 1; i >= 0; --i) {
      const double* entry = common.propagate + (Shared ? 0 : lane) + i * (n + 3) * stride;
      Vector sum[together];
      const auto add = [&](const double* from, auto&& of) {
        const Vector c = coefficient(from);
        for (int v = 0; v < together; ++v) sum[v] = multiply_add(c, of(v), sum[v]);
      };
      const Vector first = coefficient(entry);
      for (int v = 0; v < together; ++v) sum[v] = first * xi[v][0];
      for (int j = 1; j < n; ++j) add(entry + j * stride, [&](int v) { return xi[v][j]; });
      entry += n * stride;
      if constexpr (!Plain) add(entry, [&](int v) { return before[v]; });
      add(entry + stride, [&](int v) { return applied[v]; });
      if constexpr (!Plain) add(entry + 2 * stride, [&](int) { return effort; });
      for (int v = 0; v < together; ++v)
        store(common.xi + i * lanes_per_block + lane + v * vector_width, sum[v]);
    }
  }

  static Vector coefficient(const double* from) {
    return Shared ? broadcast(*from) : load(from);
  }

  // After `k` steps: whether any lane is still worth going on with.
  bool go_on(long k) const {
    const int n = size();
    const double effort = p_.effort[k - 1];
    const Vector moved = broadcast((effort < 0 ? -effort : effort) * p_.period);
    const Vector ratio = broadcast(p_.runaway_ratio);
    const bool starting = k - 1 <= samples_between_looks;
    bool any = false;
    for (int lane = 0; lane < lanes_per_block; lane += vector_width) {
      Vector largest{}, finite{};
      for (int i = 0; i < n; ++i) {
        const Vector xi = load(s_.xi + i * lanes_per_block + lane);
        largest = larger(magnitude(xi), largest);
        finite += xi - xi;  // not a number where xi is not finite
      }
      Vector reference = larger(load(c_.pushing + lane) * moved, load(s_.reference + lane));
      if (starting) reference = larger(largest, reference);
      store(s_.reference + lane, reference);
      const Mask runs = (finite == 0) & ((largest <= ratio * reference) | (reference == 0));
      const unsigned running = bits_of(runs);
      if (running == (1U << vector_width) - 1) {
        for (int i = 0; i < vector_width && !any; ++i)
          any = t_.end[lane + i] == LaneEnd::ran_through;
        continue;
      }
      for (int i = 0; i < vector_width; ++i) {
        LaneEnd& end = t_.end[lane + i];
        if ((running >> i & 1) == 0 && end == LaneEnd::ran_through) {
          end = LaneEnd::ran_away;
          t_.rows[lane + i] = k;
        }
        any = any || end == LaneEnd::ran_through;
      }
    }
    return any;
  }

  const LaneProgram& p_;
  const LaneCoefficients& c_;
  const LaneState& s_;
  const LaneTraces& t_;
  int n_, m_;
  bool plain_;
};

template <int States, int LawStates>
void run(const LaneProgram& program, const LaneCoefficients& coefficients, const LaneState& state,
         const LaneTraces& traces) {
  if (program.shared_plant) {
    Block<States, LawStates, true>(program, coefficients, state, traces).run();
  } else {
    Block<States, LawStates, false>(program, coefficients, state, traces).run();
  }
}

template <int States>
LaneKernel find_for_law(const LaneProgram& program) {
  if (program.law_is_difference) return run<States, last_sample>;
  return program.law_states == 0 ? run<States, 0> : run<States, any_size>;
}

}  // namespace

LaneKernel find_kernel(const LaneProgram& program) {
  switch (program.states) {
    case 2:
      return find_for_law<2>(program);
    case 3:
      return find_for_law<3>(program);
    case 4:
      return find_for_law<4>(program);
    case 5:
      return find_for_law<5>(program);
    case 6:
      return find_for_law<6>(program);
    case 7:
      return find_for_law<7>(program);
    case 8:
      return find_for_law<8>(program);
    default:
      return run<any_size, any_size>;
  }
}

}  // namespace gyrator::LANE_NAMESPACE
