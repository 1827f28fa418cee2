#include "support/law_list.hpp"

#include <set>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

// The indices of a variant that occur in what `index_of` makes of a list.
template <class List, class Index>
std::set<std::size_t> collect(const List& list, const Index& index_of) {
  std::set<std::size_t> found;
  for (const auto& entry : list) found.insert(index_of(entry));
  return found;
}

// Of a closed list with `size` entries.
std::set<std::size_t> all_of(std::size_t size) {
  std::set<std::size_t> all;
  for (std::size_t i = 0; i < size; ++i) all.insert(i);
  return all;
}

TEST(LawList, has_every_law_wrapper_and_velocity_estimator) {
  const auto controllers = testing::make_controller_list();
  EXPECT_EQ(collect(controllers, [](const auto& c) { return c.controller.law.index(); }),
            all_of(std::variant_size_v<Law>));
  std::set<std::size_t> wrapped;
  for (const auto& named : controllers) {
    for (const Wrapper& wrapper : named.controller.wrappers) wrapped.insert(wrapper.index());
  }
  EXPECT_EQ(wrapped, all_of(std::variant_size_v<Wrapper>));
  EXPECT_EQ(
      collect(testing::make_estimator_list(), [](const auto& e) { return e.estimator.index(); }),
      all_of(std::variant_size_v<VelocityEstimator>));
}

TEST(LawList, has_a_damper_with_every_velocity_estimator) {
  std::set<std::size_t> damped;
  for (const auto& named : testing::make_controller_list()) {
    const auto* wall = std::get_if<VirtualWall>(&named.controller.law);
    if (wall && wall->damping != 0) damped.insert(wall->velocity.index());
  }
  EXPECT_EQ(damped, all_of(std::variant_size_v<VelocityEstimator>));
}

}  // namespace
}  // namespace gyrator
