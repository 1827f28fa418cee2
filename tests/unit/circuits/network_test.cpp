#include "gyrator/circuits/network.hpp"

#include "gyrator/core/error.hpp"

#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gyrator {
namespace {

// A node "a" against ground with an ammeter (element 0), and a place for one element named "x".
struct Bench {
  Network network;
  NodeId a = network.add_node("a", Domain::electrical);
  ElementId ammeter = network.add("ammeter", a, ground, VoltageSource{});

  // The message of the refusal of `law`, which must be bad_input at the element itself.
  std::string refuse(const ElementLaw& law) {
    try {
      network.add("x", a, ground, law);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_EQ(error.place(), "x");
      EXPECT_FALSE(network.find_element("x").has_value()) << "refused, and yet in the network";
      return error.message();
    }
    return "accepted";
  }
};

TEST(Network, has_the_reference_node_from_the_start) {
  const Network network;
  ASSERT_EQ(network.nodes().size(), 1U);
  EXPECT_EQ(network.nodes().front().name, "ground");
  EXPECT_EQ(network.find_node("ground"), ground);
}

TEST(Network, numbers_nodes_inputs_and_elements_in_order_and_finds_them_by_name) {
  Network network;
  const NodeId a = network.add_node("a", Domain::electrical);
  const NodeId shaft = network.add_node("shaft", Domain::mechanical);
  EXPECT_EQ(network.add_input("u"), 0);
  EXPECT_EQ(network.add_input("f"), 1);
  const ElementId r = network.add("r", a, ground, Resistor{2});
  const ElementId m = network.add("m", shaft, ground, Capacitor{3}, Role::operator_side);
  EXPECT_EQ(network.find_node("shaft"), shaft);
  EXPECT_EQ(network.find_node("Shaft"), std::nullopt);
  EXPECT_EQ(network.find_element("r"), r);
  EXPECT_EQ(network.find_element("m"), m);
  EXPECT_EQ(network.find_element("a"), std::nullopt) << "nodes and elements are named apart";
  EXPECT_EQ(network.nodes()[2].domain, Domain::mechanical);
  EXPECT_EQ(network.element(m).role, Role::operator_side);
  EXPECT_EQ(network.element(r).role, Role::device);
  EXPECT_EQ(network.inputs(), (std::vector<std::string>{"u", "f"}));
}

TEST(Network, passive_values_must_be_positive_and_finite) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Bench bench;
  for (const double bad : {0.0, -1.0, infinity, -infinity, nan}) {
    EXPECT_NE(bench.refuse(Resistor{bad}).find("ohm: must be positive"), std::string::npos) << bad;
    EXPECT_NE(bench.refuse(Conductance{bad}).find("S: must be positive"), std::string::npos) << bad;
    EXPECT_NE(bench.refuse(Inductor{bad}).find("H: must be positive"), std::string::npos) << bad;
    EXPECT_NE(bench.refuse(Capacitor{bad}).find("F: must be positive"), std::string::npos) << bad;
  }
  EXPECT_EQ(bench.refuse(Resistor{std::numeric_limits<double>::min()}), "accepted");
}

TEST(Network, the_refusal_repeats_the_value_that_was_given) {
  Bench bench;
  EXPECT_EQ(bench.refuse(Resistor{-47}), "resistance of -47 ohm: must be positive and finite");
}

TEST(Network, gains_may_be_negative_or_zero_but_must_be_finite) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto all = [](double value) {
    return std::vector<ElementLaw>{VoltageControlledVoltageSource{value, ground, ground},
                                   VoltageControlledCurrentSource{value, ground, ground},
                                   CurrentControlledVoltageSource{value, ElementId{0}},
                                   CurrentControlledCurrentSource{value, ElementId{0}},
                                   Transformer{value, ground, ground},
                                   Gyrator{value, ground, ground}};
  };
  for (std::size_t kind = 0; kind < all(0).size(); ++kind) {
    for (const double good : {-2.5, 0.0}) {
      Bench bench;
      EXPECT_EQ(bench.refuse(all(good)[kind]), "accepted") << "kind " << kind;
    }
    Bench bench;
    EXPECT_NE(bench.refuse(all(nan)[kind]).find("must be finite"), std::string::npos) << kind;
  }
}

TEST(Network, names_of_elements_are_unique) {
  Bench bench;
  bench.network.add("x", bench.a, ground, Resistor{1});
  try {
    bench.network.add("x", bench.a, ground, Capacitor{1});
    FAIL() << "a second element of the same name was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_EQ(error.place(), "x");
    EXPECT_NE(error.message().find("unique"), std::string::npos);
  }
  EXPECT_EQ(bench.network.elements().size(), 2U);
}

TEST(Network, an_element_at_an_unknown_node_is_refused_with_the_node_number) {
  Bench bench;
  for (const int index : {2, -1, 77}) {
    for (const bool at_positive : {true, false}) {
      try {
        bench.network.add("x", at_positive ? NodeId{index} : bench.a,
                          at_positive ? bench.a : NodeId{index}, Resistor{1});
        FAIL() << "node " << index << " was accepted";
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::bad_input);
        EXPECT_EQ(error.place(), "x");
        EXPECT_NE(error.message().find("node " + std::to_string(index)), std::string::npos);
      }
    }
  }
  EXPECT_EQ(bench.network.elements().size(), 1U) << "the ammeter alone";
}

TEST(Network, a_second_port_a_control_or_an_input_that_does_not_exist_is_refused) {
  // Each would be written outside of the equations.
  const NodeId none{7};
  const std::vector<ElementLaw> laws{VoltageControlledVoltageSource{1, none, ground},
                                     VoltageControlledCurrentSource{1, ground, none},
                                     Transformer{1, none, ground},
                                     Gyrator{1, ground, none},
                                     CurrentControlledVoltageSource{1, ElementId{5}},
                                     CurrentControlledCurrentSource{1, ElementId{-1}},
                                     VoltageSource{2},
                                     CurrentSource{-1}};
  for (std::size_t kind = 0; kind < laws.size(); ++kind) {
    Bench bench;
    EXPECT_NE(bench.refuse(laws[kind]).find("does not exist"), std::string::npos) << kind;
  }
}

TEST(Network, both_sides_of_a_two_port_count_as_touching_a_node) {
  Network network;
  const NodeId a = network.add_node("a", Domain::electrical);
  const NodeId b = network.add_node("b", Domain::mechanical);
  network.add("motor", a, ground, Transformer{0.05, b, ground});
  network.add("gyrator", a, ground, Gyrator{0.05, ground, b});
  network.add("inertia", b, ground, Capacitor{1});
  // A control voltage only listens: it does not hold its node.
  network.add("amplifier", a, ground, VoltageControlledCurrentSource{1, b, ground});
  EXPECT_EQ(network.elements_at(b), (std::vector<std::string>{"motor", "gyrator", "inertia"}));
  EXPECT_EQ(network.elements_at(a), (std::vector<std::string>{"motor", "gyrator", "amplifier"}));
}

TEST(Network, only_two_different_inductors_can_be_coupled_and_no_closer_than_completely) {
  Bench bench;
  const ElementId first = bench.network.add("l1", bench.a, ground, Inductor{4e-3});
  const ElementId second = bench.network.add("l2", bench.a, ground, Inductor{1e-3});
  EXPECT_EQ(bench.refuse(MutualInductance{1e-3, first, first}),
            "couples l1 and l1: two different inductors can be coupled");
  EXPECT_EQ(bench.refuse(MutualInductance{1e-3, first, bench.ammeter}),
            "couples l1 and ammeter: two different inductors can be coupled");
  EXPECT_EQ(bench.refuse(MutualInductance{-2.1e-3, first, second}),
            "mutual inductance of -0.0021 H between l1 and l2: at most 0.002 H, the geometric mean "
            "of the two");
  EXPECT_EQ(bench.refuse(MutualInductance{1e-3, first, ElementId{7}}),
            "element 7 does not exist in the network");
  EXPECT_EQ(bench.refuse(MutualInductance{-2e-3, first, second}), "accepted");
}

}  // namespace
}  // namespace gyrator
