#include "gyrator/two_port/coupled_devices.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace gyrator {

using Complex = std::complex<double>;

std::string_view name_of(CouplingPlace place) {
  return place == CouplingPlace::both_ends ? "both_ends" : "slave";
}

CoupledDevices::CoupledDevices(const Device& master, const ComputedPath& master_path,
                               const Device& slave, const ComputedPath& slave_path,
                               const DeviceCoupling& coupling)
    : master_(master),
      slave_(slave),
      master_path_(master_path),
      slave_path_(slave_path),
      coupling_(coupling) {
  if (master_path.period == slave_path.period && master_path.step == slave_path.step) return;
  throw Error(ErrorCode::bad_input, "sampling/period",
              fmt::format("{:g} s: must be that of the device at the other end, {:g} s",
                          slave_path.period, master_path.period));
}

ImpedanceMatrix CoupledDevices::impedance_at(double omega) {
  const SampledPort m = compute_sampled_port(master_, master_path_, omega);
  const SampledPort s = compute_sampled_port(slave_, slave_path_, omega);
  const Complex C =
      VirtualElements(omega, master_path_.step, master_path_.integration).link(coupling_.law);
  const Complex there = std::polar(1.0, -omega * coupling_.delay_there);
  const Complex back = std::polar(1.0, -omega * coupling_.delay_back);
  Eigen::Matrix2cd gamma;
  if (coupling_.place == CouplingPlace::both_ends) {
    gamma << C, -C * back, -C * there, C;
  } else {
    gamma << C * there * back, -C * back, -C * there, C;
  }
  const Eigen::DiagonalMatrix<Complex, 2> feedback(m.feedback, s.feedback);
  const Eigen::DiagonalMatrix<Complex, 2> sensing(m.sensing, s.sensing);
  const Eigen::DiagonalMatrix<Complex, 2> actuation(m.actuation, s.actuation);
  const Eigen::Matrix2cd loop = Eigen::Matrix2cd::Identity() + gamma * feedback;
  const Eigen::Matrix2cd coupled = actuation * (loop.inverse() * (gamma * sensing));
  return {m.impedance + coupled(0, 0), coupled(0, 1), coupled(1, 0), s.impedance + coupled(1, 1)};
}

std::vector<double> CoupledDevices::make_grid(double highest) const {
  Eigen::VectorXcd poles(master_.poles().size() + slave_.poles().size());
  poles << master_.poles(), slave_.poles();
  const double period = master_path_.period > 0 ? master_path_.period : std::numbers::pi / highest;
  std::vector<double> grid = make_two_port_grid(poles, period);
  // A delay turns the coupling's effort round every pi/t: eight points to each turn.
  const double turn = std::max(coupling_.delay_there, coupling_.delay_back);
  const double nyquist = std::numbers::pi / period;
  constexpr double most_turns = 2000;
  if (turn > 0) {
    const double stride = std::max(std::numbers::pi / turn / 8, nyquist / (8 * most_turns));
    for (double omega = stride; omega < nyquist; omega += stride) grid.push_back(omega);
    std::sort(grid.begin(), grid.end());
    grid.erase(std::unique(grid.begin(), grid.end()), grid.end());
  }
  return grid;
}

TwoPortVerdict CoupledDevices::judge(double highest) {
  return judge_two_port([&](double omega) { return at(omega); }, make_grid(highest));
}

}  // namespace gyrator
