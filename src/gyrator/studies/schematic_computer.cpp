#include "gyrator/studies/schematic_computer.hpp"

#include "gyrator/passivity/held_limit.hpp"

#include <fmt/format.h>

namespace gyrator {
namespace {

// One function per kind; without one, std::visit does not compile.

struct EstimatorLines {
  const SchematicTerms& terms;
  BlockText& lines;

  void operator()(const DifferenceEstimator& e) const {
    lines.push_back("velocity: difference");
    if (e.window > 1) lines.push_back(fmt::format("over {} samples", e.window));
  }
  void operator()(const FilteredDifferenceEstimator& e) const {
    lines.push_back("velocity: difference,");
    lines.push_back("low-pass " + hertz(e.cutoff_hz));
  }
  void operator()(const ButterworthEstimator& e) const {
    lines.push_back("velocity: difference,");
    lines.push_back(fmt::format("Butterworth, order {},", e.order));
    lines.push_back(hertz(e.cutoff_hz));
  }
  void operator()(const AdaptiveWindowEstimator& e) const {
    lines.push_back("velocity: FOAW,");
    lines.push_back(fmt::format("{}-fit, window to {},", e.fit == WindowFit::end ? "end" : "best",
                                e.max_window));
    lines.push_back("noise " + print_quantity(e.noise, terms.units.position));
  }
  void operator()(const LevantEstimator& e) const {
    lines.push_back("velocity: Levant,");
    lines.push_back("L " + print_quantity(e.acceleration_bound, terms.units.acceleration));
  }
};

struct ControllerLines {
  const SchematicTerms& terms;
  bool held;  // only its gains are computed; an analog loop does the rest

  BlockText operator()(const NoController&) const { return {"no controller", "command 0"}; }

  BlockText operator()(const VirtualWall& wall) const {
    BlockText lines{held ? "gains of the wall" : "virtual wall",
                    "K " + terms.stiffness(wall.stiffness), "B " + terms.damping(wall.damping)};
    if (held) return lines;
    if (wall.damping != 0) std::visit(EstimatorLines{terms, lines}, wall.velocity);
    if (wall.unilateral) lines.push_back(wall.no_pull ? "unilateral, no pull" : "unilateral");
    return lines;
  }

  BlockText operator()(const PredictiveWall& wall) const {
    BlockText lines{"predictive wall", "K " + terms.stiffness(wall.stiffness),
                    "B " + terms.damping(wall.damping)};
    if (wall.prediction == PredictiveWall::Prediction::half_sample)
      lines.emplace_back("half a sample ahead");
    if (wall.dead_beat) lines.emplace_back("dead-beat at the surface");
    return lines;
  }

  BlockText operator()(const WaveController& wave) const {
    BlockText lines{"wave line"};
    if (const auto* wall = std::get_if<WaveWall>(&wave.environment)) {
      lines.push_back("K " + terms.stiffness(wall->stiffness));
      lines.push_back("B " + terms.damping(wall->damping));
      if (wall->unilateral) lines.emplace_back("unilateral");
    } else {
      lines.emplace_back("matched end");
    }
    return lines;
  }

  BlockText operator()(const VirtualCoupling& coupling) const {
    BlockText lines{"virtual coupling", "K " + terms.stiffness(coupling.coupling.stiffness),
                    "B " + terms.damping(coupling.coupling.damping),
                    "tool " + terms.inertia(coupling.tool_inertia)};
    if (coupling.wall) lines.push_back("wall " + terms.stiffness(coupling.wall->law.stiffness));
    add_update(lines, coupling.update);
    return lines;
  }

  BlockText operator()(const DirectRendering& law) const {
    return describe_object("direct rendering", law.scene);
  }
  BlockText operator()(const ProxyRendering& law) const {
    return describe_object("proxy", law.scene);
  }
  BlockText operator()(const EquivalentImpedance& law) const {
    return describe_object("equivalent impedance", law.scene);
  }

  BlockText describe_object(const char* title, const DeformableScene& scene) const {
    BlockText lines{title, "object " + terms.inertia(scene.object.inertia),
                    terms.stiffness(scene.object.to_ground.stiffness),
                    "contact " + terms.stiffness(scene.contact.stiffness)};
    add_update(lines, scene.update);
    return lines;
  }

  static void add_update(BlockText& lines, const SlowUpdate& update) {
    if (update.period) lines.push_back("every " + seconds(*update.period));
  }
};

// What is wrapped around a law, each a block of its own behind it.
struct WrapperLines {
  const SchematicTerms& terms;

  BlockText operator()(const PreEmphasis& /*stage*/) const { return {"pre-emphasis"}; }

  BlockText operator()(const BrakingPulse& pulse) const {
    return {"braking pulse", terms.damping(pulse.damping)};
  }
  BlockText operator()(const EventTransient& transient) const {
    return {"event transient", terms.damping(transient.gain), hertz(transient.frequency_hz)};
  }
  BlockText operator()(const AccelerationMatching& matching) const {
    return {"acceleration matching", "for " + terms.inertia(matching.inertia)};
  }

  BlockText operator()(const PassivityControl& control) const {
    const bool simple = control.observer == PassivityControl::Observer::simple;
    BlockText lines{"passivity control", simple ? "simple observer" : "reference energy"};
    if (control.max_damping) lines.push_back("up to " + terms.damping(*control.max_damping));
    if (control.max_effort) lines.push_back("up to " + terms.effort(*control.max_effort));
    return lines;
  }
};

}  // namespace

BlockText describe_sensor(const Sensor& sensor, const std::optional<SensorFilter>& filter,
                          const SchematicTerms& terms) {
  BlockText lines{"position sensor"};
  if (filter)
    lines.push_back((filter->order == 2 ? "low-pass, order 2 " : "low-pass ") +
                    print_quantity(filter->cutoff_hz, dimension::frequency));
  if (sensor.quantum > 0)
    lines.push_back("step " + print_quantity(sensor.quantum, terms.units.quantum));
  if (sensor.offset != 0)
    lines.push_back("offset " + print_quantity(sensor.offset, terms.units.position));
  return lines;
}

ComputerParts describe_computer(const Model& model, const SchematicTerms& terms) {
  const bool held = find_held_impedance(model.device) != nullptr;
  ComputerParts parts;
  if (held) parts.sampled = Sampled::nothing;
  if (std::holds_alternative<WaveController>(model.controller.law))
    parts.sampled = Sampled::terminal_voltage;
  parts.period = "T " + seconds(model.sampling.period);
  parts.blocks.push_back(std::visit(ControllerLines{terms, held}, model.controller.law));
  for (const Wrapper& wrapper : model.controller.wrappers)
    parts.blocks.push_back(std::visit(WrapperLines{terms}, wrapper));
  if (model.sampling.delay > Rational(0))
    parts.blocks.push_back({"delay", seconds(model.sampling.delay)});
  parts.blocks.push_back({"hold"});
  return parts;
}

}  // namespace gyrator
