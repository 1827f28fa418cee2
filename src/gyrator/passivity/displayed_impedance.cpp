#include "gyrator/passivity/displayed_impedance.hpp"

#include "gyrator/cosim/hold.hpp"

#include <cmath>

namespace gyrator {

using Complex = std::complex<double>;

DisplayedImpedance::DisplayedImpedance(const Device& device, const Sampling& sampling)
    : model_(device), period_(sampling.period.to_double()), delay_(sampling.delay.to_double()) {
  if (!build_device_network(device, FreeOperator{}).collocated)
    held_ = sample_plant(build_plant(build_device_network(device, ClampedOperator{})), sampling);
}

// y/u of (smp-1) with the port held; opposing laws have the sign in (displayed-1).
Complex DisplayedImpedance::sum_blocked(double omega) const {
  if (!held_) return 0;
  const Complex z = std::polar(1.0, omega * period_);
  const auto whole = static_cast<double>(held_->delay.whole);
  const Eigen::VectorXcd drive = held_->recent.cast<Complex>() + held_->late.cast<Complex>() / z;
  Eigen::MatrixXcd system = -held_->phi.cast<Complex>();
  system.diagonal().array() += z;
  const Complex response = (held_->sense.cast<Complex>() * system.partialPivLu().solve(drive))(0);
  return response * std::polar(1.0, -omega * period_ * whole);
}

DisplayedLoop DisplayedImpedance::at(double omega) {
  const PortResponse r = model_.at(omega);
  const Complex k0 = compute_normalized_hold(omega, period_) * std::polar(1.0, -omega * delay_) /
                     Complex(0, omega);
  return {omega, r.impedance, r.sensor_path * r.actuation * k0, sum_blocked(omega)};
}

}  // namespace gyrator
