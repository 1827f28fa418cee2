#include "gyrator/controllers/deformable.hpp"

namespace gyrator {
namespace {

// device - contact - object - ground
ChainModel make_chain(const DeformableScene& scene) {
  ChainModel model;
  model.bodies = 1;
  model.inertia[0] = scene.object.inertia;
  model.links[0] = {scene.contact, scene.unilateral};
  model.links[1] = {scene.object.to_ground, false};
  model.rest = scene.object.position;
  model.integration = scene.integration;
  model.substeps = scene.substeps;
  return model;
}

// device - coupling - tool - contact - object - ground
ChainModel make_chain(const ProxyRendering& law) {
  ChainModel model = make_chain(law.scene);
  model.bodies = 2;
  model.inertia = {law.tool_inertia, law.scene.object.inertia};
  model.links = {ChainLink{law.coupling, false}, model.links[0], model.links[1]};
  return model;
}

// The copy runs at the fast rate: it needs no substeps.
ChainModel make_copy(const DeformableScene& scene) {
  ChainModel model = make_chain(scene);
  model.substeps = 1;
  return model;
}

}  // namespace

DiscreteStateSpace make_deformable_law(const DirectRendering& law, double period) {
  require_immediate(law.scene.update, period);
  return make_chain_law(make_chain(law.scene), period);
}

DiscreteStateSpace make_deformable_law(const ProxyRendering& law, double period) {
  require_immediate(law.scene.update, period);
  return make_chain_law(make_chain(law), period);
}

DiscreteStateSpace make_deformable_law(const EquivalentImpedance& law, double period) {
  return make_chain_law(make_copy(law.scene), period);
}

RunningHeldRendering::RunningHeldRendering(const ChainModel& chain, const DeformableScene& scene,
                                           double period)
    : has_tool_(chain.bodies == 2),
      rest_(scene.object.position),
      link_(scene.update, Rational::from_double(period)),
      chain_(chain, link_.clock().period()) {
  chain_.place({{rest_, rest_}, {0, 0}});
}

RunningHeldRendering::RunningHeldRendering(const DirectRendering& law, double period)
    : RunningHeldRendering(make_chain(law.scene), law.scene, period) {}

RunningHeldRendering::RunningHeldRendering(const ProxyRendering& law, double period)
    : RunningHeldRendering(make_chain(law), law.scene, period) {}

double RunningHeldRendering::step(double y) {
  if (!started_) {
    last_ = y;
    if (has_tool_) chain_.place({{y, rest_}, {0, 0}});
    started_ = true;
  }
  return -link_.exchange([&] {
    const double velocity = (y - last_) / link_.clock().period();
    last_ = y;
    return chain_.advance(y, velocity);
  });
}

double RunningHeldRendering::surface_position() const {
  return chain_.state().position[has_tool_ ? 1 : 0];
}

void RunningHeldRendering::append_signal_names(std::vector<std::string>& names) const {
  if (has_tool_) names.emplace_back("tool_position");
  names.emplace_back("surface_position");
}

double* RunningHeldRendering::write_signals(double* value) const {
  if (has_tool_) *value++ = chain_.state().position[0];
  *value++ = surface_position();
  return value;
}

RunningEquivalentImpedance::RunningEquivalentImpedance(const EquivalentImpedance& law,
                                                       double period)
    : period_(period),
      described_(law.scene.object),
      link_(law.scene.update, Rational::from_double(period)),
      object_(make_chain(law.scene), link_.clock().period()),
      copy_(make_copy(law.scene), period),
      unilateral_(law.scene.unilateral) {
  const double rest = described_.position;
  object_.place({{rest, 0}, {0, 0}});
  copy_.place({{rest, 0}, {0, 0}});
}

double RunningEquivalentImpedance::step(double y) {
  if (!started_) last_ = y;
  started_ = true;
  const Conveyed& known = link_.exchange([&] {
    object_.push(ticks_ > 0 ? pushed_ / static_cast<double>(ticks_) : 0.0);
    pushed_ = 0;
    ticks_ = 0;
    return Conveyed{described_, object_.state().position[0], object_.state().velocity[0]};
  });
  if (link_.arrived()) {
    copy_.set_last(known.impedance.inertia, known.impedance.to_ground, known.impedance.position);
    if (unilateral_ && !touching_ && y <= known.surface)
      copy_.place({{known.surface, 0}, {known.surface_velocity, 0}});
  }
  const double velocity = (y - last_) / period_;
  last_ = y;
  const double effort = copy_.advance(y, velocity);
  touching_ = effort != 0;
  pushed_ += effort;
  ++ticks_;
  return -effort;
}

}  // namespace gyrator
