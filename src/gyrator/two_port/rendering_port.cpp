#include "gyrator/two_port/rendering_port.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// What is computed: F = a w + b f_e, -v_e = c w + d f_e.
struct Computed {
  Complex a, b, c, d;
};

HybridMatrix join(const SampledPort& port, const Computed& law) {
  const Complex q = 1.0 + law.a * port.feedback;
  return {port.impedance + port.actuation * law.a * port.sensing / q, port.actuation * law.b / q,
          law.c * port.sensing / q, law.d - law.c * law.b * port.feedback / q};
}

// (rendering-1)
double find_delay(const SlowUpdate& update, const Sampling& sampling) {
  const double period = sampling.period.to_double();
  const double late = std::ceil(update.delay.to_double() / period * (1 - 1e-12));
  const bool slower = update.period && *update.period > sampling.period;
  return sampling.delay.to_double() + period * std::max(late, slower ? 1.0 : 0.0);
}

void take_deformable(RenderedScene& scene, const DeformableScene& given, const Sampling& sampling) {
  scene.contact = given.contact;
  scene.object = RenderedScene::Object{given.object.inertia, given.object.to_ground};
  const Rational period = given.update.period.value_or(sampling.period);
  scene.path.period = period.to_double();
  scene.path.step = scene.path.period / given.substeps;
  scene.path.integration = given.integration;
  scene.path.delay = find_delay(given.update, sampling);
}

struct SceneMaker {
  const Sampling& sampling;
  RenderedScene& scene;

  void operator()(const DirectRendering& law) const {
    scene.own = Rendering::direct;
    take_deformable(scene, law.scene, sampling);
  }
  void operator()(const ProxyRendering& law) const {
    scene.own = Rendering::proxy;
    take_deformable(scene, law.scene, sampling);
    scene.tool = RenderedScene::Tool{law.tool_inertia, 0, law.coupling};
  }
  void operator()(const EquivalentImpedance& law) const {
    scene.own = Rendering::equivalent_impedance;
    take_deformable(scene, law.scene, sampling);
  }
  void operator()(const VirtualCoupling& law) const {
    const double period = sampling.period.to_double();
    require_immediate(law.update, period);
    scene.own = Rendering::proxy;
    scene.tool = RenderedScene::Tool{law.tool_inertia, law.tool_damping, law.coupling};
    if (law.wall) scene.object = RenderedScene::Object{0, law.wall->law};
    scene.path.period = period;
    scene.path.step = period / law.substeps;
    scene.path.integration = law.integration;
    scene.path.delay = sampling.delay.to_double();
  }
  template <class Other>
  void operator()(const Other& /*law*/) const {
    throw Error(ErrorCode::bad_input, "controller/kind",
                "no environment behind a coupling, of which there would be a two-port: use direct, "
                "proxy, equivalent_impedance or virtual_coupling, or --remote for two devices");
  }
};

}  // namespace

std::string_view name_of(Rendering rendering) {
  switch (rendering) {
    case Rendering::direct:
      return "direct";
    case Rendering::proxy:
      return "proxy";
    case Rendering::equivalent_impedance:
      break;
  }
  return "equivalent_impedance";
}

RenderedScene make_rendered_scene(const Controller& controller, const Sampling& sampling) {
  RenderedScene scene;
  std::visit(SceneMaker{sampling, scene}, controller.law);
  scene.path.tick = sampling.period.to_double();
  scene.path.output = make_output_law(controller);
  return scene;
}

RenderingPort::RenderingPort(const Device& device, const RenderedScene& scene)
    : scene_(scene), device_(device) {}

SpringDamper RenderingPort::contact() const {
  return scene_.contact ? *scene_.contact : scene_.tool->coupling;
}

std::vector<Rendering> RenderingPort::available() const {
  std::vector<Rendering> renderings{Rendering::direct};
  if (scene_.tool) renderings.push_back(Rendering::proxy);
  if (scene_.object) renderings.push_back(Rendering::equivalent_impedance);
  return renderings;
}

void RenderingPort::require(Rendering rendering) const {
  const auto list = available();
  if (std::find(list.begin(), list.end(), rendering) != list.end()) return;
  const bool proxy = rendering == Rendering::proxy;
  throw Error(ErrorCode::bad_input, proxy ? "controller/tool" : "controller/environment",
              fmt::format("missing: {} needs {}", name_of(rendering),
                          proxy ? "a simulated tool and its coupling, such as a model of kind "
                                  "\"proxy\" has"
                                : "an object whose impedance could be conveyed"));
}

HybridMatrix RenderingPort::at(Rendering rendering, double omega) {
  require(rendering);
  const VirtualElements elements(omega, scene_.path.step, scene_.path.integration);
  const Complex yielding = 1.0 / elements.link(contact());
  if (rendering == Rendering::equivalent_impedance) {
    ComputedPath beside;
    beside.period = 0;
    return join(compute_sampled_port(device_, beside, omega),
                {*environment_impedance(omega), 0, -1, yielding});
  }
  const SampledPort port = compute_sampled_port(device_, scene_.path, omega);
  if (rendering == Rendering::direct)
    return join(port, {scene_.passivity_damping, 1, -1, yielding});
  const Complex coupling = elements.link(scene_.tool->coupling);
  const Complex tool = elements.body(scene_.tool->inertia, {0, scene_.tool->damping});
  const Complex share = coupling / (coupling + tool);
  const Complex tied = 1.0 / (coupling + tool);
  return join(port, {share * tool, share, -share, scene_.contact ? yielding + tied : tied});
}

std::optional<Complex> RenderingPort::environment_impedance(double omega) const {
  if (!scene_.object) return std::nullopt;
  const VirtualElements elements(omega, scene_.path.step, scene_.path.integration);
  return elements.body(scene_.object->inertia, scene_.object->to_ground);
}

double RenderingPort::computed_radius(Rendering rendering) const {
  const ComputedPath& path = scene_.path;
  double radius = 0;
  if (rendering != Rendering::proxy || scene_.contact)
    radius = compute_virtual_radius(0, contact(), path.step, path.integration);
  if (rendering != Rendering::proxy) return radius;
  SpringDamper tied = scene_.tool->coupling;
  tied.damping += scene_.tool->damping;
  return std::max(radius,
                  compute_virtual_radius(scene_.tool->inertia, tied, path.step, path.integration));
}

std::vector<double> RenderingPort::make_grid() const {
  Eigen::VectorXcd poles = device_.poles();
  const auto add = [&](double inertia, const SpringDamper& law) {
    if (!(inertia > 0) || !(law.stiffness > 0)) return;
    poles.conservativeResize(poles.size() + 1);
    const double half = law.damping / (2 * inertia);
    poles(poles.size() - 1) = -half + std::sqrt(Complex(half * half - law.stiffness / inertia));
  };
  if (scene_.tool) add(scene_.tool->inertia, scene_.tool->coupling);
  if (scene_.object) add(scene_.object->inertia, scene_.object->to_ground);
  return make_two_port_grid(poles, scene_.path.period);
}

TwoPortVerdict RenderingPort::judge(Rendering rendering) {
  require(rendering);
  return judge_two_port([&](double omega) { return at(rendering, omega); }, make_grid(),
                        computed_radius(rendering));
}

}  // namespace gyrator
