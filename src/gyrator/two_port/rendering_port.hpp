#pragma once

#include "gyrator/controllers/controller.hpp"
#include "gyrator/controllers/sampling.hpp"
#include "gyrator/two_port/sampled_port.hpp"
#include "gyrator/two_port/two_port.hpp"

#include <optional>
#include <string_view>
#include <vector>

namespace gyrator {

/// Three ways of letting a device touch a simulated object.
enum class Rendering { direct, proxy, equivalent_impedance };
std::string_view name_of(Rendering rendering);

/// The values that the three share; what a controller does not have is none.
struct RenderedScene {
  struct Tool {
    double inertia = 0;     ///< [kg, kg.m^2]
    double damping = 0;     ///< to ground [N.s/m, N.m.s/rad]
    SpringDamper coupling;  ///< to the device
  };
  struct Object {
    double inertia = 0;  ///< [kg, kg.m^2]
    SpringDamper to_ground;
  };
  Rendering own = Rendering::direct;    ///< what the controller does
  std::optional<SpringDamper> contact;  ///< none: tool and object are one point
  std::optional<Tool> tool;
  std::optional<Object> object;
  ComputedPath path;
  double passivity_damping = 0;  ///< C_pc around direct rendering [N.s/m, N.m.s/rad]
};

/// The scene of a controller that is computed for a two-port: direct, proxy, equivalent_impedance,
/// or a virtual_coupling (a proxy whose tool is itself in touch with its wall). The command is held
/// over the update's period P; the delay is that of `sampling` and
///   max(ceil(D/T), [P > T]) T                                                       (rendering-1)
/// of the update, D its delay and T the loop's period (as (slow-2), for P a multiple of T).
/// Throws bad_input, at controller/kind, for any other law, and at controller/update for a
/// virtual coupling at two rates.
RenderedScene make_rendered_scene(const Controller& controller, const Sampling& sampling);

/// Hybrid matrices of the renderings on a device. With what is computed as
///   F = a w + b f_e,   -v_e = c w + d f_e
///   direct                 a = C_pc,                       b = 1,     c = -1,  d = 1/Z_c     (K1)
///   proxy                  a = Z_vc Z_t/(Z_vc + Z_t),      b = r,     c = -r,
///                          d = 1/Z_c + 1/(Z_vc + Z_t),     r = Z_vc/(Z_vc + Z_t)             (K6)
///   equivalent impedance   a = Z_eq = Z_e,                 b = 0,     c = -1,  d = 1/Z_c    (K11)
/// and (sampled-1),
///   q = 1 + a V M P,    h11 = Z + A P a V S/q,    h12 = A P b/q,
///   h21 = c V S/q,      h22 = d - c b V M P/q                                       (rendering-2)
/// Z_c contact, Z_vc coupling, Z_t tool, Z_e object by (virtual-1). An equivalent impedance acts in
/// the drive, beside the device: for it alone P = V = 1. On an ideal drive with mass and damper,
/// without delay, velocity sensed, these are the paper's matrices.
/// Without a contact (a virtual coupling) 1/Z_c is absent from the proxy, and the coupling's in the
/// two others.
/// Source: Kim and Lee 2017; A, S, M, wrappers and delay derived.
class RenderingPort {
 public:
  /// Throws as PortModel does.
  RenderingPort(const Device& device, const RenderedScene& scene);

  /// The renderings that the scene has values for.
  std::vector<Rendering> available() const;
  /// Throws bad_input, at controller, naming the value that is missing.
  void require(Rendering rendering) const;

  HybridMatrix at(Rendering rendering, double omega);

  /// Z_e of the object; none without one.
  std::optional<std::complex<double>> environment_impedance(double omega) const;

  /// Over make_two_port_grid of the device's poles and those of what is computed.
  TwoPortVerdict judge(Rendering rendering);

  const RenderedScene& scene() const { return scene_; }
  PortModel& device() { return device_; }
  std::vector<double> make_grid() const;

 private:
  SpringDamper contact() const;
  double computed_radius(Rendering rendering) const;

  RenderedScene scene_;
  PortModel device_;
};

}  // namespace gyrator
