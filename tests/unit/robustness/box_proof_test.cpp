#include "gyrator/robustness/box_proof.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/passivity/disk_proof.hpp"
#include "gyrator/passivity/stiffness_limit.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "support/box_examples.hpp"

namespace gyrator {
namespace {

using testing::BoxExample;
using testing::is_passive_at;
using testing::list_box_examples;

BoxProof prove(const BoxExample& example, const BoxBudget& budget = {}) {
  return prove_box(example.maker, example.parts, example.sampling, example.law(), budget);
}

DiskProof prove_at(const BoxExample& example, const std::vector<double>& values) {
  PortModel model(example.maker(values));
  return prove_disk(model, example.sampling, example.law());
}

BoxExample with_stiffness(BoxExample example, double stiffness) {
  std::get<VirtualWall>(example.controller.law).stiffness = stiffness;
  return example;
}

bool contains(const PartBox& box, const std::vector<double>& values) {
  bool inside = values.size() == box.center.size();
  for (std::size_t i = 0; inside && i < values.size(); ++i)
    inside = std::abs(values[i] - box.center[i]) <= box.half[i] * (1 + 1e-12);
  return inside;
}

// K = 2 b/T.
TEST(BoxProof, OfAnIdealDriveReachesTwiceTheLowestDampingOverThePeriod) {
  const BoxExample example = list_box_examples().front();
  const double lowest = example.parts.center[1] - example.parts.half[1];
  const double limit = 2 * lowest / example.sampling.period.to_double();
  const BoxProof below = prove(with_stiffness(example, 0.99 * limit));
  EXPECT_EQ(below.outcome, BoxOutcome::passive) << below.reason;
  EXPECT_GT(below.margin, 0);
  const BoxProof above = prove(with_stiffness(example, 1.01 * limit));
  ASSERT_EQ(above.outcome, BoxOutcome::not_passive) << above.reason;
  EXPECT_DOUBLE_EQ(above.at[1], lowest);
  EXPECT_LT(above.margin, 0);
}

// The limit falls or rises with each of these parts: the worst corner's is the box's.
TEST(BoxProof, OfAnRcCircuitReachesTheWorstCorner) {
  const BoxExample example = list_box_examples()[1];
  const std::size_t parts = example.parts.center.size();
  const double damping = std::get<VirtualWall>(example.controller.law).damping;
  double limit = INFINITY;
  for (unsigned corner = 0; corner < 1U << parts; corner += 1) {
    constexpr unsigned inertia = 1U << 4;  // is no part of the limit
    if ((corner & inertia) != 0) continue;
    std::vector<double> places;
    for (std::size_t i = 0; i < parts; ++i) places.push_back((corner >> i & 1U) != 0 ? 1 : -1);
    StiffnessLimits limits(example.maker(example.values_at(places)), example.sampling,
                           example.controller, FreeOperator{});
    limit = std::min(limit, limits.find(Criterion::exact_disk, damping).stiffness);
  }
  const BoxProof below = prove(with_stiffness(example, 0.97 * limit));
  EXPECT_EQ(below.outcome, BoxOutcome::passive) << below.reason;
  const BoxProof above = prove(with_stiffness(example, 1.03 * limit));
  EXPECT_EQ(above.outcome, BoxOutcome::not_passive) << above.reason;
}

TEST(BoxProof, HoldsAtRandomPointsOfItsBox) {
  constexpr int points = 150;  // of each example, about half a millisecond each
  RandomStream random(3, 0);
  for (BoxExample& example : list_box_examples()) {
    // A resonance that moves by several of its widths takes many boxes.
    if (example.name.starts_with("compliant")) {
      for (double& half : example.parts.half) half *= 0.25;
    }
    const BoxProof proof = prove(example);
    ASSERT_EQ(proof.outcome, BoxOutcome::passive) << example.name << ": " << proof.reason;
    for (int i = 0; i < points; ++i) {
      const std::vector<double> places = example.draw_places(random);
      ASSERT_TRUE(is_passive_at(example, example.values_at(places)))
          << example.name << " at " << ::testing::PrintToString(places);
    }
  }
}

TEST(BoxProof, ShowsPartsThatAreNotPassiveWhereThereAreSome) {
  for (const std::size_t i : {std::size_t{1}, std::size_t{2}, std::size_t{3}}) {
    const BoxExample nominal = list_box_examples()[i];
    StiffnessLimits limits(nominal.maker(nominal.parts.center), nominal.sampling,
                           nominal.controller, FreeOperator{});
    const auto& wall = std::get<VirtualWall>(nominal.controller.law);
    const double limit = limits.find(Criterion::exact_disk, wall.damping).stiffness;
    const BoxExample example = with_stiffness(nominal, 0.98 * limit);
    ASSERT_EQ(prove_at(example, example.parts.center).outcome, ProofOutcome::proved);
    const BoxProof proof = prove(example);
    ASSERT_EQ(proof.outcome, BoxOutcome::not_passive) << example.name << ": " << proof.reason;
    EXPECT_TRUE(contains(example.parts, proof.at)) << example.name;
    EXPECT_EQ(prove_at(example, proof.at).outcome, ProofOutcome::violated) << example.name;
  }
}

// A spring that pushes away has D = b + |K| T/2 > 0, but nothing holds the free device.
TEST(BoxProof, SaysWhyWhereTheNominalLoopIsUnstableWithNothingAttached) {
  const BoxExample example = with_stiffness(list_box_examples().front(), -0.02);
  ASSERT_EQ(prove_at(example, example.parts.center).outcome, ProofOutcome::proved);
  const BoxProof proof = prove(example);
  ASSERT_EQ(proof.outcome, BoxOutcome::not_passive);
  EXPECT_EQ(proof.at, example.parts.center);
  EXPECT_NE(proof.reason.find("unstable with nothing attached"), std::string::npos) << proof.reason;
  EXPECT_TRUE(std::isnan(proof.margin)) << "no margin says it";
}

TEST(BoxProof, IsUndecidedWhereTheBudgetEnds) {
  BoxExample example = list_box_examples()[5];
  ASSERT_EQ(example.name, "compliant, sensor at motor");
  const BoxProof proof = prove(example, {2, 600});
  EXPECT_EQ(proof.outcome, BoxOutcome::undecided);
  EXPECT_EQ(proof.boxes, 2U);
  EXPECT_NE(proof.reason, "");
  EXPECT_TRUE(contains(example.parts, proof.at));
  EXPECT_GT(proof.omega, 0);
}

TEST(BoxProof, RefusesAPartThatVanishesInTheBox) {
  BoxExample example = list_box_examples()[1];
  example.parts.half[2] = example.parts.center[2];  // the inductance
  EXPECT_THROW(
      {
        try {
          prove(example);
        } catch (const Error& error) {
          EXPECT_NE(error.message().find("vanishes"), std::string::npos) << error.message();
          throw;
        }
      },
      Error);
}

}  // namespace
}  // namespace gyrator
