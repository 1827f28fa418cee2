#pragma once

#include "gyrator/passivity/displayed_impedance.hpp"
#include "gyrator/passivity/passive_walls.hpp"

#include <cstddef>
#include <vector>

namespace gyrator {

/// The walls of one velocity estimator that a criterion calls passive, with what gives H = o (K + B
/// V).
struct WallChoice {
  LawFamily family;
  PassiveWalls walls;
};

/// An extreme of |Z_cl| at one frequency and the wall that has it.
struct DisplayedExtreme {
  double magnitude = 0;  ///< [N.s/m, N.m.s/rad]; infinite where a wall of the region makes it so
  WallPoint wall;
  std::size_t choice = 0;  ///< which of the WallChoices
};

struct EnvelopePoint {
  double frequency_hz = 0;
  double bare = 0;  ///< |Z|, nothing commanded
  DisplayedExtreme highest, lowest;
};

/// The extremes of |Z_cl| of (displayed-1) over all walls of all choices, at each frequency [Hz,
/// below Nyquist].
///
/// Over (K, B) the law H = o (K + B V) is affine, and Z_cl = (Z + H (S A k_0 + m Z))/(1 + H m) of
/// it an analytic function. |Z_cl| has its largest value on the region's edge unless 1 + H m = 0
/// inside, and its smallest unless Z_cl = 0 inside (maximum modulus).               (envelope-1)
/// Where the exact disk calls every wall of the region passive neither happens, as Re Z_cl > 0 and
/// the held loop is stable; for the other criteria both points are looked for, and the extreme is
/// then infinity or zero. On a straight side |Z_cl|^2 is a ratio of two quadratics of the place on
/// it, whose extremes are the roots of a quadratic: nothing is searched, and only the polygon
/// (outline_tolerance) is approximate.
/// Source of the idea: Weir and Colgate, Stability of haptic displays, 8.3; the edge argument is
/// checked with random walls in impedance_envelope_test.
std::vector<EnvelopePoint> compute_impedance_envelope(DisplayedImpedance& displayed,
                                                      const std::vector<WallChoice>& choices,
                                                      const std::vector<double>& frequency_hz);

/// Figures of merit of an envelope over its frequencies, trapezoids over log10 f.
struct EnvelopeAreas {
  double logarithmic =
      0;                 ///< of log10(highest/lowest) d log10 f [decades^2], of |Z| and |1/Z| alike
  double impedance = 0;  ///< of (highest - lowest) d log10 f [N.s/m decades]
  double admittance = 0;  ///< of (1/lowest - 1/highest) d log10 f [m/(N.s) decades]
};
EnvelopeAreas compute_envelope_areas(const std::vector<EnvelopePoint>& envelope);

}  // namespace gyrator
