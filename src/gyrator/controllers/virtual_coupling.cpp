#include "gyrator/controllers/virtual_coupling.hpp"

namespace gyrator {
namespace {

ChainModel make_tool(const VirtualCoupling& c) {
  ChainModel model;
  model.bodies = 1;
  model.inertia[0] = c.tool_inertia;
  model.damping[0] = c.tool_damping;
  model.links[0] = {c.coupling, false};
  if (c.wall) {
    model.links[1] = {c.wall->law, c.wall->unilateral};
    model.rest = c.wall->position;
  }
  model.integration = c.integration;
  model.substeps = c.substeps;
  return model;
}

}  // namespace

DiscreteStateSpace make_coupling_law(const VirtualCoupling& coupling, double period) {
  require_immediate(coupling.update, period);
  return make_chain_law(make_tool(coupling), period);
}

RunningVirtualCoupling::RunningVirtualCoupling(const VirtualCoupling& coupling, double period)
    : coupling_(coupling.coupling),
      period_(period),
      immediate_(is_immediate(coupling.update, period)),
      link_(coupling.update, Rational::from_double(period)),
      tool_(make_tool(coupling), link_.clock().period()) {}

double RunningVirtualCoupling::step(double y) {
  if (!started_) {
    last_ = last_slow_ = y;
    tool_.place({{y, 0}, {0, 0}});
    link_.start_with({y, 0});
    started_ = true;
  }
  const double velocity = (y - last_) / period_;
  last_ = y;
  if (immediate_) return -tool_.advance(y, velocity);
  const Tool& tool = link_.exchange([&] {
    tool_.advance(y, (y - last_slow_) / link_.clock().period());
    last_slow_ = y;
    return Tool{tool_.state().position[0], tool_.state().velocity[0]};
  });
  return -(coupling_.stiffness * (y - tool.position) +
           coupling_.damping * (velocity - tool.velocity));
}

}  // namespace gyrator
