#include "gyrator/amplifiers/register_blocks.hpp"

#include <algorithm>

namespace gyrator {

std::vector<RegisterBlock> plan_blocks(std::vector<const DeviceRegister*> places, int max_read,
                                       int max_hole) {
  constexpr int most_bits = 2000;
  std::stable_sort(places.begin(), places.end(),
                   [](const DeviceRegister* a, const DeviceRegister* b) {
                     return std::pair(a->table, a->address) < std::pair(b->table, b->address);
                   });
  std::vector<RegisterBlock> blocks;
  for (const DeviceRegister* place : places) {
    const int end = place->address + place->words();
    if (!blocks.empty()) {
      RegisterBlock& last = blocks.back();
      const int last_end = last.address + last.count;
      const int most = holds_bits(place->table) ? most_bits : max_read;
      const bool joins = last.table == place->table && place->address - last_end <= max_hole &&
                         std::max(end, last_end) - last.address <= most;
      if (joins) {
        last.count = std::max(end, last_end) - last.address;
        last.places.push_back(place);
        continue;
      }
    }
    blocks.push_back({place->table, place->address, place->words(), {place}});
  }
  return blocks;
}

}  // namespace gyrator
