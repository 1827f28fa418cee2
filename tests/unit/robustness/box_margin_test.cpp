#include "gyrator/passivity/aliased_disk.hpp"
#include "gyrator/robustness/box_disk.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include "support/box_examples.hpp"

namespace gyrator {
namespace {

using testing::BoxExample;
using testing::list_box_examples;
using Complex = std::complex<double>;
using std::numbers::pi;

constexpr double tail_end = 1e7;  // [rad/s]

// First order of a model at a point of its box, d_0 first.
Complex first_order(const BoxModel& model, double place, const std::vector<double>& places) {
  Complex value = model.value + model.slopes[0] * place;
  for (std::size_t i = 0; i < places.size(); ++i) value += model.slopes[i + 1] * places[i];
  return value;
}

// Of the base range: at rest, in the middle, at the end.
std::vector<Band> list_bands(double period) {
  const double nyquist = pi / period;
  return {{nyquist / 64, nyquist / 64},
          {nyquist / 4, nyquist / 32},
          {nyquist / 2, nyquist / 16},
          {nyquist * 31 / 32, nyquist / 32}};
}

PartBox shrink(PartBox box, double factor) {
  for (double& half : box.half) half *= factor;
  return box;
}

// Rounding of the reference, of its size.
constexpr double reference_rounding = 1e-9;

// Entry by entry: convex ones bend away from their slopes.
TEST(BoxDescriptor, KeepsTheEquationsOfEveryDeviceWithinItsRemainders) {
  constexpr double rounding = 1e-12;  // of an entry: a few operations
  for (const BoxExample& example : list_box_examples()) {
    const BoxDescriptorMaker maker(example.maker, example.parts);
    const BoxDescriptor box = maker.make(example.parts);
    RandomStream random(4, 0);
    for (int i = 0; i < 30; ++i) {
      const std::vector<double> places = example.draw_places(random);
      const PartBox point{example.values_at(places), std::vector<double>(places.size())};
      const BoxDescriptor known = maker.make(point);
      for (const bool storage : {true, false}) {
        const Eigen::MatrixXd& exact = storage ? known.E : known.A;
        Eigen::MatrixXd linear = storage ? box.E : box.A;
        Eigen::MatrixXd allowed = rounding * (linear.cwiseAbs() + exact.cwiseAbs());
        for (const auto& term : box.terms) {
          if (term.storage != storage) continue;
          const Eigen::MatrixXd stamp = term.row * term.column.transpose();
          for (std::size_t k = 0; k < places.size(); ++k)
            linear += places[k] * term.slopes[k] * stamp;
          allowed += term.remainder * stamp.cwiseAbs();
        }
        EXPECT_LE(((exact - linear).cwiseAbs() - allowed).maxCoeff(), 0)
            << example.name << (storage ? " E" : " A");
      }
    }
  }
}

TEST(BoxPort, KeepsEveryPointWithinItsRemainder) {
  for (BoxExample& example : list_box_examples()) {
    const BoxDescriptorMaker maker(example.maker, example.parts);
    const double period = example.sampling.period.to_double();
    for (const double size : {1.0, 0.2}) {
      BoxExample part = example;
      part.parts = shrink(example.parts, size);
      const BoxPortModel model(maker.make(part.parts));
      RandomStream random(1, 0);
      for (const Band& band : list_bands(period)) {
        const DividedPort port = model.expand_divided(band);
        const BoxPort plain = model.expand(band);
        for (int i = 0; i < 40; ++i) {
          const std::vector<double> places = part.draw_places(random);
          const double place = 2 * random.uniform() - 1;
          const double omega = band.omega + place * band.reach;
          PortModel exact(part.maker(part.values_at(places)));
          const PortResponse response = exact.at(omega);
          const PortResponse rest = exact.at(1e-6);
          const Complex path = response.sensor_path * response.actuation;
          const Complex path_at_rest = (rest.sensor_path * rest.actuation).real();
          const auto check = [&](const char* what, const BoxModel& q, Complex known,
                                 double rounding) {
            EXPECT_LE(std::abs(known - first_order(q, place, places)),
                      q.remainder + reference_rounding * std::abs(known) + rounding)
                << example.name << " " << what << " at " << omega;
          };
          check("damping", port.damping, response.impedance.real(), 1e-15);
          check("path", port.path.f, path, 0);
          check("path, plain", plain.path, path, 0);
          check("blocked", port.blocked.f, response.blocked_motion, 1e-15);
          // The reference has a difference of large numbers here.
          check("path's difference", port.path.q1, (path - path_at_rest) / Complex(0, omega),
                1e-9 * std::abs(path) / omega);
          check("path at rest", port.path.c0, path_at_rest, 1e-9);
        }
      }
    }
  }
}

TEST(BoxMargin, IsNowhereAboveTheExactDisksInTheBox) {
  for (BoxExample& example : list_box_examples()) {
    const BoxDescriptorMaker maker(example.maker, example.parts);
    const double period = example.sampling.period.to_double();
    const DiscreteStateSpace law = example.law();
    const SampledSide side{law, period, example.sampling.delay.to_double(),
                           law.response(1.0).real()};
    for (const double size : {0.5, 0.01}) {
      BoxExample part = example;
      part.parts = shrink(example.parts, size);
      const BoxPortModel model(maker.make(part.parts));
      const BoxAliases aliases(model, period, side.delay, 8, tail_end);
      RandomStream random(2, 0);
      for (Band band : list_bands(period)) {
        band.reach *= band.low() > 0 ? size : 1;
        const BoxMargin bound = bound_margin(model, side, aliases.sum(band), band);
        for (int i = 0; i < 20; ++i) {
          const std::vector<double> places = part.draw_places(random);
          const double place = 2 * random.uniform() - 1;
          const double omega = band.omega + place * band.reach;
          AliasedDisk disk(part.maker(part.values_at(places)), example.sampling);
          const double known =
              disk.at(omega).damping_margin(law.response(std::polar(1.0, omega * period)));
          const double first = first_order(bound.margin, place, places).real();
          const double scale = bound.size;
          EXPECT_GE(known, first - bound.margin.remainder - 1e-7 * scale)
              << example.name << " at " << omega << " size " << size;
          // And useful: close where the box is small.
          if (size < 0.1 && band.low() > 0) {
            EXPECT_LE(known, first + bound.margin.remainder + 0.02 * scale)
                << example.name << " at " << omega;
            EXPECT_LE(bound.margin.remainder, 0.05 * scale) << example.name << " at " << omega;
          }
        }
      }
    }
  }
}

// Aliases summed over a band are used for the bands that it is divided into.
TEST(BoxMargin, IsABoundWithTheAliasesOfAWiderBandToo) {
  for (BoxExample& example : list_box_examples()) {
    const BoxDescriptorMaker maker(example.maker, example.parts);
    const double period = example.sampling.period.to_double();
    const DiscreteStateSpace law = example.law();
    const SampledSide side{law, period, example.sampling.delay.to_double(),
                           law.response(1.0).real()};
    BoxExample part = example;
    part.parts = shrink(example.parts, 0.01);
    const BoxPortModel model(maker.make(part.parts));
    const BoxAliases aliases(model, period, side.delay, 8, tail_end);
    RandomStream random(3, 0);
    const Band whole{std::numbers::pi / period * 0.8, std::numbers::pi / period * 0.1};
    const AliasSums sums = aliases.sum(whole);
    for (const double shift : {-0.75, 0.0, 0.75}) {
      const Band band{whole.omega + shift * whole.reach, whole.reach / 4};
      const AliasSums moved = sums.over(band);
      const BoxMargin bound = bound_margin(model, side, sums, band);
      for (int i = 0; i < 10; ++i) {
        const std::vector<double> places = part.draw_places(random);
        const double place = 2 * random.uniform() - 1;
        const Complex here = first_order(moved.center, place, places);
        EXPECT_NEAR(std::abs(here - first_order(sums.center, shift + place / 4, places)), 0,
                    1e-12 * std::abs(here))
            << example.name;
        const double omega = band.omega + place * band.reach;
        AliasedDisk disk(part.maker(part.values_at(places)), example.sampling);
        const double known =
            disk.at(omega).damping_margin(law.response(std::polar(1.0, omega * period)));
        EXPECT_GE(known, first_order(bound.margin, place, places).real() - bound.margin.remainder -
                             1e-7 * bound.size)
            << example.name << " at " << omega;
      }
    }
  }
}

}  // namespace
}  // namespace gyrator
