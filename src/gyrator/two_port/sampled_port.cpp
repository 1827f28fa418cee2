#include "gyrator/two_port/sampled_port.hpp"

#include "gyrator/cosim/hold.hpp"

namespace gyrator {

std::string_view name_of(Sensing sensing) {
  return sensing == Sensing::velocity ? "velocity" : "position";
}

SampledPort compute_sampled_port(PortModel& device, const ComputedPath& path, double omega) {
  using Complex = std::complex<double>;
  const PortResponse r = device.at(omega);
  const Complex known =
      path.sensing == Sensing::position ? compute_normalized_hold(omega, path.step) : Complex(1);
  const Complex held = compute_normalized_hold(omega, path.period) *
                       path.output.response(std::polar(1.0, omega * path.tick)) *
                       std::polar(1.0, -omega * path.delay);
  return {r.impedance, r.actuation * held, known * r.sensor_path, known * r.blocked_motion * held};
}

}  // namespace gyrator
