#include "gyrator/synthesis/design_reasons.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

using nlohmann::json;

DesignSpec make_spec() {
  const json document{{"schema", "gyrator/design/1"},
                      {"model", "examples/compare/re25_none.json"},
                      {"objective", {{"maximize", "stiffness"}, {"virtual_damping", 1e-4}}},
                      {"topologies", {"resistor", "rc"}}};
  return parse_design_spec(document, "spec.json");
}

Design make_design(const DesignOption& option, double stiffness, double yield, double inertia) {
  Design design;
  design.candidate.option = &option;
  design.candidate.figures.max_stiffness = stiffness;
  design.candidate.figures.apparent_inertia = inertia;
  design.candidate.merit = {true, stiffness};
  design.yield.value = yield;
  return design;
}

// The order into which the designs come from every order that they can be given in; empty where
// that depends on it.
std::vector<std::size_t> sort_all_ways(const DesignSpec& spec, const std::vector<Design>& designs) {
  std::vector<std::size_t> given(designs.size());
  std::iota(given.begin(), given.end(), 0);
  std::vector<std::size_t> order;
  do {
    std::vector<Design> sorted;
    for (const std::size_t i : given) {
      sorted.push_back(designs[i]);
      sorted.back().reason = std::to_string(i);
    }
    sort_designs(spec, sorted);
    std::vector<std::size_t> now;
    for (const Design& design : sorted) now.push_back(std::stoul(design.reason));
    if (!order.empty() && now != order) return {};
    order = now;
  } while (std::next_permutation(given.begin(), given.end()));
  return order;
}

TEST(SortDesigns, DoesNotDependOnTheGivenOrderWhereEqualityDoesNotPassOn) {
  const DesignSpec spec = make_spec();
  const DesignOption& option = spec.options.back();
  const std::vector<Design> designs{make_design(option, 1, 0.5, 1e-7),
                                    make_design(option, 1 - 0.8e-6, 0.7, 1e-7),
                                    make_design(option, 1 - 1.6e-6, 0.9, 1e-7)};
  // The third is equal to the second, but not to the stiffest.
  EXPECT_EQ(sort_all_ways(spec, designs), (std::vector<std::size_t>{1, 0, 2}));
}

TEST(SortDesigns, TakesAmongEqualsYieldThenPartsThenInertia) {
  const DesignSpec spec = make_spec();
  const DesignOption& one_part = spec.options.front();
  const DesignOption& two_parts = spec.options.back();
  const std::vector<Design> designs{
      make_design(two_parts, 1, 0.5, 1e-7), make_design(two_parts, 1, 0.5, 5e-8),
      make_design(one_part, 1, 0.5, 2e-7), make_design(two_parts, 1 - 5e-7, 0.6, 3e-7),
      make_design(one_part, 0.99, 1, 0)};
  EXPECT_EQ(sort_all_ways(spec, designs), (std::vector<std::size_t>{3, 2, 1, 0, 4}));
}

}  // namespace
}  // namespace gyrator
