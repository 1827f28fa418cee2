#include "gyrator/robustness/box_disk.hpp"

#include <cmath>
#include <numbers>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

constexpr double at_rest = 1e-9;  // of what is seen at the Nyquist frequency

}  // namespace

bool has_limit_at_rest(const BoxPortModel& port, const SampledSide& side) {
  if (port.collocated() || side.steady_law == 0) return true;
  const double seen = plain_abs(port.expand({std::numbers::pi / side.period, 0}).blocked.value);
  return port.expand_divided({0, 0}).blocked.c0.highest_size() <= at_rest * seen;
}

BoxMargin bound_margin(const BoxPortModel& port, const SampledSide& side, const AliasSums& about,
                       const Band& band) {
  const AliasSums aliases = about.over(band);
  const DividedPort base = port.expand_divided(band);
  DividedModel law = expand_law_divided(side.law, side.period, band);
  law.c0 = constant_box(side.steady_law);
  const DividedModel turn = expand_turn(band, side.delay);
  const DividedModel hold = expand_hold(band, side.period);
  const DividedModel command = law * hold * turn;  // H k_0 = command/s
  const DividedModel f = command * base.path;
  const DividedModel N = command * base.blocked;  // over s

  const BoxModel s = band.s();
  const BoxModel held = law.f * hold.f;
  const BoxModel E = Complex(-1) * (held * (turn.f * aliases.center));
  const BoxModel G = majorant(held) * aliases.radius;
  const BoxModel W = constant_box(1) + N.q1 + s * E;
  const BoxModel wG = Complex(0, -1) * (s * G);
  const BoxModel spread = majorant(f.f) * G;
  const BoxModel damping = base.damping * (square_size(W) - wG * wG);

  const BoxModel drive = real_part(conj(W) * f.q1);
  const BoxModel pole = real_part(f.c0) * real_part(N.q2 + E);
  BoxMargin result;
  result.margin = real_part(damping + drive - pole - spread);
  if (band.low() > 0) {
    const BoxModel direct = real_part(damping + conj(W) * (f.f * reciprocal(s)) - spread);
    // Not the other way round: where the divided form knows nothing it is not a number.
    const bool divided_is_better = result.margin.lowest_real() >= direct.lowest_real();
    if (!divided_is_better && std::isfinite(direct.lowest_real())) result.margin = direct;
  }
  result.size = plain_abs(damping.value) + plain_abs(W.value) * plain_abs(f.q1.value) +
                plain_abs(f.c0.value) * plain_abs(N.q2.value + E.value) + plain_abs(spread.value);
  result.keeps_sign =
      f.c0.highest_size() == 0 || plain_abs(f.c0.value) > f.c0.spread() + f.c0.remainder;
  result.is_damped = base.damping.lowest_real() > 0;
  return result;
}

}  // namespace gyrator
