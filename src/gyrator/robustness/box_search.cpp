#include "gyrator/robustness/box_search.hpp"

#include "gyrator/core/interrupt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gyrator {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int base_bands = 16;
constexpr double narrowest = 1e-9;       // band, of the Nyquist frequency
constexpr double band_preference = 0.3;  // a band is divided sooner than all of the box
constexpr double own_aliases = 0.3;      // band, of that of its aliases, below which to sum anew

class Search {
 public:
  Search(const BoxDescriptorMaker& descriptors, const SampledSide& side,
         const SearchSettings& settings, const SearchBox& box)
      : side_(side),
        box_(box),
        base_(make_base_bands(side.period)),
        descriptor_(descriptors.make(box.parts)),
        port_(descriptor_),
        aliases_(port_, side.period, side.delay, settings.direct, settings.tail_end),
        sums_(base_.size()),
        votes_(box.parts.center.size()),
        unknown_votes_(votes_.size()) {}

  BoxPass run() {
    pass_.lowest = infinity;
    pass_.margin = infinity;
    for (const Band& band : box_.bands) cover(band);
    if (!pass_.open.empty()) {
      const auto& votes =
          std::any_of(unknown_votes_.begin(), unknown_votes_.end(), [](double v) { return v > 0; })
              ? unknown_votes_
              : votes_;
      pass_.split =
          static_cast<std::size_t>(std::max_element(votes.begin(), votes.end()) - votes.begin());
    }
    return std::move(pass_);
  }

 private:
  // What the remainder of D would lose if one variable's range were halved.
  struct Gains {
    double band = 0, aliases = 0;
    std::vector<double> parts;
  };

  void cover(const Band& whole) {
    std::vector<Band> open{whole};
    while (!open.empty()) {
      throw_if_interrupted("tolerance");
      const Band band = open.back();
      open.pop_back();
      AliasSums sums = sums_about(band);
      BoxMargin margin = bound_margin(port_, side_, sums, band);
      ++pass_.intervals;
      if (holds(margin)) continue;
      if (divides(band, sums, margin)) {
        const double low = band.low();
        const double high = band.high();
        const double middle = low > 0 && high > 3 * low ? std::sqrt(low * high)
                              : low > 0                 ? band.omega
                                                        : high / 4;
        open.push_back({(low + middle) / 2, (middle - low) / 2});
        open.push_back({(middle + high) / 2, (high - middle) / 2});
      } else if (!holds(margin)) {
        give_up(band, margin);
      }
    }
  }

  bool holds(const BoxMargin& margin) {
    if (!(margin.lowest() > 0) || !margin.is_damped || !margin.keeps_sign) return false;
    pass_.lowest = std::min(pass_.lowest, margin.lowest());
    return true;
  }

  const AliasSums& sums_about(const Band& band) {
    const auto i =
        std::min(static_cast<std::size_t>(band.omega / (2 * base_[0].reach)), base_.size() - 1);
    if (!sums_[i]) sums_[i] = aliases_.sum(base_[i]);
    return *sums_[i];
  }

  // Whether to divide the band, rather than the box along the part that votes are given to. May
  // find better aliases and that the margin holds with them.
  bool divides(const Band& band, AliasSums& sums, BoxMargin& margin) {
    if (band.reach < narrowest / side_.period) {
      vote_by_width();
      return false;
    }
    if (!std::isfinite(margin.margin.remainder)) return divides_unknown(band, sums);
    const Gains gains = find_gains(band, sums, margin);
    const auto part = std::max_element(gains.parts.begin(), gains.parts.end());
    if (gains.aliases > std::max(gains.band, *part)) {
      if (band.reach < own_aliases * base_[0].reach) {
        sums = aliases_.sum(band);
        margin = bound_margin(port_, side_, sums, band);
        if (holds(margin)) return false;
        const Gains again = find_gains(band, sums, margin);
        if (again.aliases > again.band) {
          vote_by_aliases(sums, again.aliases);
          return false;
        }
        return true;
      }
      if (gains.aliases > 0.7 * margin.margin.remainder) return true;
    }
    if (gains.band > band_preference * *part) return true;
    for (std::size_t i = 0; i < votes_.size(); ++i) votes_[i] += gains.parts[i];
    return false;
  }

  // Where nothing is known yet: by what the response's own width suffers from, in the same way.
  bool divides_unknown(const Band& band, const AliasSums& sums) {
    const BoxMargin still = bound_margin(port_, side_, sums, {band.omega, 0});
    if (std::isfinite(still.margin.remainder)) return true;
    const double width = port_.find_width(band);
    const double narrower = port_.find_width({band.omega, band.reach / 2});
    std::vector<double> gains;
    for (std::size_t i = 0; i < votes_.size(); ++i)
      gains.push_back(width - BoxPortModel(descriptor_.with_half(i)).find_width(band));
    const double most = *std::max_element(gains.begin(), gains.end());
    if (!(width > 0.5) || !std::isfinite(width) || !(most > 0)) {
      vote_by_width();
      return false;
    }
    if (width - narrower > band_preference * most) return true;
    for (std::size_t i = 0; i < votes_.size(); ++i) unknown_votes_[i] += gains[i] / most;
    return false;
  }

  Gains find_gains(const Band& band, const AliasSums& sums, const BoxMargin& margin) const {
    const double remainder = margin.margin.remainder;
    const auto gain = [&](const BoxPortModel& port, const AliasSums& with, const Band& over) {
      const double left = bound_margin(port, side_, with, over).margin.remainder;
      return std::isfinite(left) ? remainder - left : 0;
    };
    Gains gains;
    gains.band = gain(port_, sums, {band.omega, band.reach / 2});
    AliasSums exact = sums;
    exact.center.remainder = exact.radius.remainder = 0;
    gains.aliases = gain(port_, exact, band);
    for (std::size_t i = 0; i < box_.parts.center.size(); ++i) {
      AliasSums halved = sums;
      halved.center.slopes[i + 1] /= 2;
      halved.radius.slopes[i + 1] /= 2;
      gains.parts.push_back(gain(BoxPortModel(descriptor_.with_half(i)), halved, band));
    }
    return gains;
  }

  void vote_by_aliases(const AliasSums& sums, double gain) {
    std::size_t most = 0;
    for (std::size_t i = 0; i < votes_.size(); ++i) {
      if (plain_abs(sums.radius.slopes[i + 1]) > plain_abs(sums.radius.slopes[most + 1])) most = i;
    }
    votes_[most] += gain;
  }

  // Nothing is known of what the parts do: the relatively widest.
  void vote_by_width() {
    std::size_t widest = 0;
    double most = -1;
    for (std::size_t i = 0; i < votes_.size(); ++i) {
      const double width =
          box_.parts.half[i] / (std::abs(box_.parts.center[i]) + box_.parts.half[i]);
      if (width <= most) continue;
      most = width;
      widest = i;
    }
    votes_[widest] += 1e-300;
  }

  void give_up(const Band& band, const BoxMargin& margin) {
    pass_.open.push_back(band);
    const BoxModel& D = margin.margin;
    const double lowest = std::isfinite(D.remainder) ? D.lowest_real() : 0;
    if (pass_.open.size() > 1 && !(lowest < pass_.margin)) return;
    pass_.margin = lowest;
    pass_.omega = band.omega;
    pass_.suspect.reset();
    if (!std::isfinite(D.remainder) || D.lowest_real() + D.remainder > 0) return;
    std::vector<double> corner = box_.parts.center;
    for (std::size_t i = 0; i < corner.size(); ++i) {
      const double slope = D.slopes[i + 1].real();
      if (slope != 0) corner[i] -= std::copysign(box_.parts.half[i], slope);
    }
    pass_.suspect = std::move(corner);
  }

  const SampledSide& side_;
  const SearchBox& box_;
  std::vector<Band> base_;
  BoxDescriptor descriptor_;
  BoxPortModel port_;
  BoxAliases aliases_;
  std::vector<std::optional<AliasSums>> sums_;
  std::vector<double> votes_, unknown_votes_;
  BoxPass pass_;
};

}  // namespace

std::vector<Band> make_base_bands(double period) {
  std::vector<Band> bands;
  const double reach = std::numbers::pi / period / base_bands / 2;
  for (int i = 0; i < base_bands; ++i) bands.push_back({(2 * i + 1) * reach, reach});
  return bands;
}

BoxPass search_box(const BoxDescriptorMaker& descriptors, const SampledSide& side,
                   const SearchSettings& settings, const SearchBox& box) {
  return Search(descriptors, side, settings, box).run();
}

}  // namespace gyrator
