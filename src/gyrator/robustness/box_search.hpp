#pragma once

#include "gyrator/robustness/box_disk.hpp"

#include <optional>
#include <vector>

namespace gyrator {

/// A box of parts and the base frequencies for which it is not yet proved.
struct SearchBox {
  PartBox parts;
  std::vector<Band> bands;
  double volume = 1;  ///< of the whole box
};

struct SearchSettings {
  int direct = 8;       ///< aliases that follow the frequency on either side
  double tail_end = 0;  ///< from where on a power law continues the aliases [rad/s]
};

/// What one pass over a box has left.
struct BoxPass {
  std::vector<Band> open;     ///< for which the box is too wide
  std::size_t intervals = 0;  ///< looked at
  double lowest = 0;          ///< bound of D where it is proved
  std::size_t split = 0;      ///< part along which to divide
  // The worst of those open:
  double omega = 0, margin = 0;
  std::optional<std::vector<double>> suspect;  ///< a corner at which D <= 0 to first order
};

/// All base frequencies 0 … pi/T, in the bands over which aliases are summed once.
std::vector<Band> make_base_bands(double period);

/// Proves D > 0 for the box's bands, dividing them while that is what their bounds suffer from.
BoxPass search_box(const BoxDescriptorMaker& descriptors, const SampledSide& side,
                   const SearchSettings& settings, const SearchBox& box);

}  // namespace gyrator
