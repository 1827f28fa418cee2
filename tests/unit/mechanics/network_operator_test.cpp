#include "gyrator/core/error.hpp"
#include "gyrator/mechanics/plant.hpp"

#include <gtest/gtest.h>

#include "support/device_list.hpp"

namespace gyrator {
namespace {

using testing::make_p3;

NetworkOperator parse(const std::string& lines) {
  return {parse_subcircuit(".subckt hand port ground\n" + lines + ".ends\n", "hand.cir", "")};
}

TEST(NetworkOperator, of_a_mass_spring_and_damper_is_the_operator_of_that_name) {
  const NetworkOperator network =
      parse("C1 port ground 0.4\nR1 port ground 0.2\nL1 port ground 0.005\n");
  const MassSpringDamper hand{.inertia = 0.4, .damping = 5, .stiffness = 200, .resonators = {}};
  const Plant a = build_plant(build_device_network(make_p3(), network));
  const Plant b = build_plant(build_device_network(make_p3(), hand));
  ASSERT_EQ(a.states(), b.states());
  // The same equations up to rounding of 1/0.2 and 1/0.005.
  EXPECT_TRUE(a.A.isApprox(b.A, 1e-13));
  EXPECT_TRUE(a.B.isApprox(b.B, 1e-13));
  EXPECT_TRUE(a.rest.isApprox(b.rest, 1e-13));
  EXPECT_TRUE(a.energy.stored.isApprox(b.energy.stored, 1e-13))
      << "the operator's is not the device's";
  EXPECT_TRUE(a.energy.operator_work.isApprox(b.energy.operator_work, 1e-13));
}

TEST(NetworkOperator, with_an_inner_mass_is_a_resonator_that_starts_with_the_port) {
  const NetworkOperator network = parse("L1 port n 0.01\nC1 n ground 0.3\n");
  const MassSpringDamper hand{.resonators = {{.inertia = 0.3, .stiffness = 100}}};
  const Plant a = build_plant(build_device_network(make_p3(), network));
  const Plant b = build_plant(build_device_network(make_p3(), hand));
  ASSERT_EQ(a.states(), b.states());
  EXPECT_TRUE(a.A.isApprox(b.A, 1e-13));
  EXPECT_TRUE(a.rest.isApprox(b.rest, 1e-13)) << "its mass moves along from the start";
}

TEST(NetworkOperator, refuses_what_is_not_passive_by_its_elements_with_file_and_line) {
  for (const char* line :
       {"V1 port ground 1\n", "I1 port ground 1\n", "E1 n ground port ground 2\nR2 n ground 1\n",
        "G1 port ground port ground 1\n", "D1 port ground dio\n.model dio D\n"}) {
    try {
      check_passive_operator(parse(std::string("R1 port ground 0.2\n") + line));
      FAIL() << line << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_TRUE(error.place().starts_with("hand.cir:3")) << error.place();
      EXPECT_NE(error.message().find("passive"), std::string::npos) << error.message();
    }
  }
  EXPECT_THROW(parse("R1 port ground -0.2\n"), Error);
}

}  // namespace
}  // namespace gyrator
