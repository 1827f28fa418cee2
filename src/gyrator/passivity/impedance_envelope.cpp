#include "gyrator/passivity/impedance_envelope.hpp"

#include "gyrator/core/interrupt.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace gyrator {
namespace {

using Complex = std::complex<double>;
constexpr double infinity = std::numeric_limits<double>::infinity();

// |a + b t|^2 as value + slope t + curvature t^2.
struct Quadratic {
  double value, slope, curvature;
};
Quadratic square_of(Complex a, Complex b) {
  return {std::norm(a), 2 * std::real(std::conj(a) * b), std::norm(b)};
}

// Where in (0, 1) the ratio n/d of two quadratics is stationary: n' d - n d' = 0, its cubic terms
// cancel.
std::array<std::optional<double>, 2> find_stationary(const Quadratic& n, const Quadratic& d) {
  const double c = n.slope * d.value - n.value * d.slope;
  const double b = 2 * (n.curvature * d.value - n.value * d.curvature);
  const double a = n.curvature * d.slope - n.slope * d.curvature;
  const auto inside = [](double t) {
    return t > 0 && t < 1 ? std::optional<double>(t) : std::nullopt;
  };
  const double discriminant = b * b - 4 * a * c;
  if (!(discriminant >= 0)) return {};
  const double q = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
  return {inside(q != 0 ? c / q : 0), inside(a != 0 ? q / a : 0)};
}

// The extremes at one frequency, over one choice after the other.
class Search {
 public:
  explicit Search(const DisplayedLoop& loop) : loop_(loop) {
    point_.frequency_hz = loop.omega / (2 * std::numbers::pi);
    point_.bare = std::abs(loop.bare);
    point_.highest.magnitude = -infinity;
    point_.lowest.magnitude = infinity;
  }

  void take(const WallChoice& choice, std::size_t index) {
    const LawFamily::Point law = choice.family.prepare(loop_.omega);
    velocity_ = law.velocity;
    output_ = law.output;
    index_ = index;
    const auto& outline = choice.walls.outline;
    for (std::size_t i = 0; i < outline.size(); ++i)
      walk_side(outline[i], outline[(i + 1) % outline.size()]);
    // H where Z_cl vanishes, and where it has no bound.
    const Complex numerator = loop_.path + loop_.blocked * loop_.bare;
    if (const auto wall = find_wall(choice.walls, -loop_.bare, numerator)) note(*wall, 0);
    if (const auto wall = find_wall(choice.walls, -1, loop_.blocked)) note(*wall, infinity);
  }

  const EnvelopePoint& found() const { return point_; }

 private:
  Complex law_of(const WallPoint& wall) const {
    return output_ * (wall.stiffness + wall.damping * velocity_);
  }

  void note(const WallPoint& wall, double magnitude) {
    if (magnitude > point_.highest.magnitude) point_.highest = {magnitude, wall, index_};
    if (magnitude < point_.lowest.magnitude) point_.lowest = {magnitude, wall, index_};
  }

  void walk_side(const WallPoint& from, const WallPoint& to) {
    note(from, std::abs(loop_.displayed(law_of(from))));
    const Complex start = law_of(from);
    const Complex along = law_of(to) - start;
    const Complex gain = loop_.path + loop_.blocked * loop_.bare;
    const auto stationary =
        find_stationary(square_of(loop_.bare + gain * start, gain * along),
                        square_of(1.0 + loop_.blocked * start, loop_.blocked * along));
    for (const auto& t : stationary) {
      if (!t) continue;
      const WallPoint wall{from.stiffness + *t * (to.stiffness - from.stiffness),
                           from.damping + *t * (to.damping - from.damping)};
      note(wall, std::abs(loop_.displayed(law_of(wall))));
    }
  }

  // The wall within the region whose law is numerator/denominator.
  std::optional<WallPoint> find_wall(const PassiveWalls& walls, Complex numerator,
                                     Complex denominator) const {
    const Complex law = numerator / (denominator * output_);
    const double damping = law.imag() / velocity_.imag();
    const WallPoint wall{law.real() - damping * velocity_.real(), damping};
    const bool is_wall = std::isfinite(wall.stiffness) && std::isfinite(damping);
    return is_wall && walls.contains(wall) ? std::optional(wall) : std::nullopt;
  }

  DisplayedLoop loop_;
  Complex velocity_, output_;
  std::size_t index_ = 0;
  EnvelopePoint point_;
};

// Trapezoids over log10 f of what is wanted at each point.
template <class Function>
double integrate(const std::vector<EnvelopePoint>& envelope, const Function& wanted) {
  double area = 0;
  for (std::size_t i = 1; i < envelope.size(); ++i) {
    const double width = std::log10(envelope[i].frequency_hz / envelope[i - 1].frequency_hz);
    area += width * (wanted(envelope[i]) + wanted(envelope[i - 1])) / 2;
  }
  return area;
}

}  // namespace

std::vector<EnvelopePoint> compute_impedance_envelope(DisplayedImpedance& displayed,
                                                      const std::vector<WallChoice>& choices,
                                                      const std::vector<double>& frequency_hz) {
  std::vector<EnvelopePoint> envelope;
  envelope.reserve(frequency_hz.size());
  for (const double frequency : frequency_hz) {
    throw_if_interrupted("zwidth");
    Search search(displayed.at(2 * std::numbers::pi * frequency));
    for (std::size_t i = 0; i < choices.size(); ++i) search.take(choices[i], i);
    envelope.push_back(search.found());
    envelope.back().frequency_hz = frequency;
  }
  return envelope;
}

EnvelopeAreas compute_envelope_areas(const std::vector<EnvelopePoint>& envelope) {
  EnvelopeAreas areas;
  areas.logarithmic = integrate(envelope, [](const EnvelopePoint& p) {
    return std::log10(p.highest.magnitude / p.lowest.magnitude);
  });
  areas.impedance = integrate(
      envelope, [](const EnvelopePoint& p) { return p.highest.magnitude - p.lowest.magnitude; });
  areas.admittance = integrate(envelope, [](const EnvelopePoint& p) {
    return 1 / p.lowest.magnitude - 1 / p.highest.magnitude;
  });
  return areas;
}

}  // namespace gyrator
