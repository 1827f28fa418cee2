#include "gyrator/verification/certificate_check.hpp"
#include "gyrator/verification/discrepancies.hpp"
#include "gyrator/verification/sampled_disk.hpp"
#include "gyrator/verification/sampled_loop.hpp"

#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Long = long double;
using LongComplex = std::complex<long double>;

Discrepancies check_operator(const HeldDevice& device, const Sampling& sampling,
                             const DiscreteStateSpace& law, const OperatorRefutation& recorded) {
  Discrepancies list;
  const MassSpringDamper& held_by = recorded.held_by;
  const auto need = [&](const std::string& field, double value, bool allowed) {
    if (allowed && std::isfinite(value)) return;
    report(list, field, fmt::format("recorded {:.12g}: a passive operator has none", value));
  };
  need("refutation/inertia", held_by.inertia, held_by.inertia >= 0);
  need("refutation/damping", held_by.damping, held_by.damping >= 0);
  need("refutation/stiffness", held_by.stiffness, held_by.stiffness >= 0);
  for (std::size_t i = 0; i < held_by.resonators.size(); ++i) {
    const auto& r = held_by.resonators[i];
    need(fmt::format("refutation/resonators/{}/inertia", i), r.inertia, r.inertia > 0);
    need(fmt::format("refutation/resonators/{}/stiffness", i), r.stiffness, r.stiffness >= 0);
  }
  if (!list.empty()) return list;
  const LoopPole pole = find_loop_pole(device, sampling, law, held_by);
  if (!(pole.magnitude > 1 + stable_pole)) {
    report(list, "refutation/spectral_radius",
           fmt::format("found {:.12g}: the loop does not diverge", pole.magnitude));
  }
  compare(list, "refutation/spectral_radius", recorded.spectral_radius, pole.magnitude, 1e-8);
  compare(list, "refutation/frequency_hz", recorded.frequency_hz, pole.frequency_hz,
          1e-6 * pole.frequency_hz + 1e-9);
  return list;
}

Discrepancies check_uncoupled(const HeldDevice& device, const Sampling& sampling,
                              const DiscreteStateSpace& law, const UncoupledRefutation& recorded) {
  Discrepancies list;
  const double radius = find_loop_pole(device, sampling, law, {}).magnitude;
  if (!(radius > 1 + stable_pole)) {
    report(list, "refutation/spectral_radius",
           fmt::format("found {:.12g}: the loop does not diverge", radius));
  }
  compare(list, "refutation/spectral_radius", recorded.spectral_radius, radius, same_pole);
  return list;
}

Discrepancies check_active(const HeldDevice& device, const DeviceRefutation& recorded) {
  Discrepancies list;
  const HeldResponse response = compute_held_response(device, recorded.omega);
  const auto damping = static_cast<double>(response.impedance.real());
  const auto size = static_cast<double>(std::abs(response.impedance));
  if (!(damping <= 0)) {
    report(list, "refutation/omega",
           fmt::format("recorded {:.12g} rad/s: Re Z = {:.6g} there is above zero", recorded.omega,
                       damping));
  }
  compare(list, "refutation/damping", recorded.damping, damping,
          1e-6 * std::abs(damping) + margin_rounding * size);
  return list;
}

Discrepancies check_exceeded(const HeldDevice& device, const Sampling& sampling,
                             const DiscreteStateSpace& law, const DiskRefutation& recorded) {
  Discrepancies list;
  const double nyquist = std::numbers::pi / sampling.period.to_double();
  if (!(recorded.omega > 0) || !(recorded.omega <= nyquist * (1 + frequency_agreement))) {
    report(list, "refutation/omega",
           fmt::format("recorded {:.12g}: above zero and at most {:.12g} rad/s", recorded.omega,
                       nyquist));
    return list;
  }
  const SampledDiskPoint point = SampledDisk(device, sampling).at(recorded.omega);
  const LongComplex H = compute_law(
      law, recorded.omega * static_cast<Long>(sampling.period.num()) / sampling.period.den());
  const auto radius = static_cast<double>(point.radius);
  const auto margin = static_cast<double>(point.margin(H));
  const double off_law = std::abs(recorded.law - narrow(H));
  const double off_center = std::abs(recorded.center - narrow(point.center));
  const double reserve = largest_reserve - 1;
  if (!(off_law <= number_agreement * std::abs(recorded.law)))
    report(list, "refutation/law_real", fmt::format("off by {:.6g}", off_law));
  if (!(off_center <= reserve * radius))
    report(list, "refutation/center_real", fmt::format("off by {:.6g}", off_center));
  if (!(recorded.radius <= largest_reserve * radius && radius <= recorded.radius * (1 + reserve)))
    compare(list, "refutation/radius", recorded.radius, radius, 0);
  if (!(margin <= 0)) {
    report(list, "refutation/margin",
           fmt::format("found {:.12g}: the disk is not exceeded at {:.12g} rad/s", margin,
                       recorded.omega));
  }
  const auto terms =
      static_cast<double>(point.damping * std::norm(H) * point.radius * point.radius);
  compare(list, "refutation/margin", recorded.margin, margin,
          reserve * std::abs(margin) + margin_rounding * terms);
  return list;
}

}  // namespace

std::vector<Discrepancy> check_refutation(const HeldDevice& device, const Sampling& sampling,
                                          const DiscreteStateSpace& law,
                                          const Refutation& refutation) {
  struct Check {
    const HeldDevice& device;
    const Sampling& sampling;
    const DiscreteStateSpace& law;
    Discrepancies operator()(const OperatorRefutation& r) const {
      return check_operator(device, sampling, law, r);
    }
    Discrepancies operator()(const UncoupledRefutation& r) const {
      return check_uncoupled(device, sampling, law, r);
    }
    Discrepancies operator()(const DeviceRefutation& r) const { return check_active(device, r); }
    Discrepancies operator()(const DiskRefutation& r) const {
      return check_exceeded(device, sampling, law, r);
    }
  };
  return std::visit(Check{device, sampling, law}, refutation);
}

}  // namespace gyrator
