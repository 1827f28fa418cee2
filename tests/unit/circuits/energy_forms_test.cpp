#include "gyrator/circuits/energy_forms.hpp"

#include "gyrator/mechanics/device.hpp"

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A sum of some hundred products, each known to rounding.
constexpr double rounding = 1e-12;

struct Case {
  std::string name;
  NetworkEquations equations;
  Reduction reduction;
  EnergyForms energy;

  Case(std::string title, const DeviceNetwork& device)
      : name(std::move(title)),
        equations(device.network),
        reduction(reduce(equations.descriptor())),
        energy(build_energy_forms(equations, reduction, device.operator_ammeter)) {}
};

// Every device of the list in free air, in a hand and clamped.
void for_every_case(const std::function<void(const Case&)>& check) {
  const MassSpringDamper hand{.inertia = 3e-5, .damping = 2e-4, .stiffness = 0.3, .resonators = {}};
  for (const auto& [name, device] : testing::make_device_list()) {
    check(Case(name + ", free", build_device_network(device, FreeOperator{})));
    check(Case(name + ", held", build_device_network(device, hand)));
    check(Case(name + ", clamped", build_device_network(device, ClampedOperator{})));
  }
}

// A state in which every part holds about the same energy, and inputs of about one part's effort.
VectorXd draw_state(std::mt19937& generator, const Case& c) {
  std::normal_distribution<double> normal;
  VectorXd z(c.energy.stored.rows());
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    const double stored = c.energy.stored(i, i);
    z(i) = normal(generator) / (stored > 0 ? std::sqrt(stored) : 1);
  }
  return z;
}

TEST(EnergyForms, obey_tellegen_for_every_drive_and_mechanics) {
  // Sources and operator deliver what goes into store and heat, z'Pz + z'Hz = d/dt z'Sz + z'Dz,
  // with d/dt z = [A w + B u; 0]                                                      (led-1)
  std::mt19937 generator(4);
  for_every_case([&](const Case& c) {
    const Eigen::Index n = c.reduction.A.rows();
    for (int trial = 0; trial < 5; ++trial) {
      const VectorXd z = draw_state(generator, c);
      VectorXd rate = VectorXd::Zero(z.size());
      rate.head(n) = c.reduction.A * z.head(n) + c.reduction.B * z.tail(2);
      const double source = z.dot(c.energy.source * z);
      const double hand = z.dot(c.energy.operator_work * z);
      const double storing = 2 * z.dot(c.energy.stored * rate);
      const double heat = z.dot(c.energy.dissipated * z);
      const double largest =
          z.cwiseAbs().dot((c.energy.source.cwiseAbs() + c.energy.operator_work.cwiseAbs() +
                            c.energy.dissipated.cwiseAbs()) *
                           z.cwiseAbs()) +
          2 * z.cwiseAbs().dot(c.energy.stored.cwiseAbs() * rate.cwiseAbs());
      EXPECT_LE(std::abs(source + hand - storing - heat), rounding * largest) << c.name;
    }
  });
}

TEST(EnergyForms, are_symmetric_and_neither_store_nor_heat_is_ever_negative) {
  for_every_case([&](const Case& c) {
    for (const MatrixXd* form : {&c.energy.stored, &c.energy.dissipated, &c.energy.source,
                                 &c.energy.operator_work, &c.energy.source_jump}) {
      EXPECT_EQ(*form, form->transpose()) << c.name;
    }
    for (const MatrixXd* form : {&c.energy.stored, &c.energy.dissipated}) {
      // Scaled to a unit diagonal, so that a negative part of any unit would show.
      const VectorXd d = form->diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
      const MatrixXd scaled = d.asDiagonal() * *form * d.asDiagonal();
      const VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<MatrixXd>(scaled).eigenvalues();
      EXPECT_GE(eigenvalues.minCoeff(), -rounding) << c.name;
    }
  });
}

TEST(EnergyForms, a_jump_of_the_command_costs_exactly_the_energy_that_appears_in_store) {
  // At a jump w stays; heat takes no part (no impulse passes a resistor), nor does the operator.
  std::mt19937 generator(5);
  int with_impulse = 0;
  for_every_case([&](const Case& c) {
    const Eigen::Index n = c.reduction.A.rows();
    VectorXd before = draw_state(generator, c);
    VectorXd after = before;
    after(n) += 0.7;
    VectorXd jump(n + 4);
    jump << before.head(n), before.tail(2), after.tail(2);
    const double work = jump.dot(c.energy.source_jump * jump);
    const double stored_before = before.dot(c.energy.stored * before);
    const double stored_after = after.dot(c.energy.stored * after);
    EXPECT_NEAR(work, stored_after - stored_before, rounding * (stored_before + stored_after))
        << c.name;
    with_impulse += std::abs(work) > 1e-6 * stored_before ? 1 : 0;
  });
  EXPECT_GE(with_impulse, 6) << "the list has hardly any index-2 drive: what does this test?";
}

TEST(EnergyForms, of_one_inductor_and_one_capacitor_are_the_textbooks) {
  Network network;
  const int u = network.add_input("u");
  const NodeId a = network.add_node("a", Domain::electrical);
  const NodeId b = network.add_node("b", Domain::electrical);
  network.add("source", a, ground, VoltageSource{u});
  network.add("l", a, b, Inductor{0.2});
  network.add("c", b, ground, Capacitor{3});
  network.add("r", b, ground, Resistor{5});
  const NetworkEquations equations(network);
  const Reduction reduction = reduce(equations.descriptor());
  const EnergyForms energy = build_energy_forms(equations, reduction, std::nullopt);
  ASSERT_EQ(reduction.A.rows(), 2);
  // Which of the two states is which: read it from the recovery.
  const auto row = [&](const LinearForm& form) {
    const ReducedForm r = reduction.reduce(form);
    return (Eigen::RowVector3d() << r.state, r.input).finished();
  };
  const Eigen::RowVector3d i = row(equations.through(*network.find_element("l")));
  const Eigen::RowVector3d v = row(equations.across(*network.find_element("c")));
  const Eigen::RowVector3d source = Eigen::RowVector3d::Unit(2);
  EXPECT_TRUE(energy.stored.isApprox(0.1 * i.transpose() * i + 1.5 * v.transpose() * v, rounding));
  EXPECT_TRUE(energy.dissipated.isApprox(v.transpose() * v / 5, rounding));
  EXPECT_TRUE(
      energy.source.isApprox(0.5 * (source.transpose() * i + i.transpose() * source), rounding));
  EXPECT_TRUE(energy.operator_work.isZero(0));
}

TEST(EnergyForms, signals_and_the_operators_own_parts_are_not_the_devices_energy) {
  const auto build = [](Role role) {
    Network network;
    const int u = network.add_input("u");
    const NodeId a = network.add_node("a", Domain::electrical);
    const NodeId b = network.add_node("b", Domain::electrical);
    network.add("source", a, ground, VoltageSource{u}, role);
    network.add("r", a, b, Resistor{1}, role);
    network.add("c", b, ground, Capacitor{1}, role);
    const NetworkEquations equations(network);
    return build_energy_forms(equations, reduce(equations.descriptor()), std::nullopt);
  };
  EXPECT_GT(build(Role::device).stored.norm(), 0.1);
  EXPECT_GT(build(Role::device).source.norm(), 0.1);
  EXPECT_GT(build(Role::device).dissipated.norm(), 0.1);
  for (const Role role : {Role::signal, Role::operator_side}) {
    EXPECT_TRUE(build(role).stored.isZero(0));
    EXPECT_TRUE(build(role).source.isZero(0));
    EXPECT_TRUE(build(role).dissipated.isZero(0));
  }
}

}  // namespace
}  // namespace gyrator
