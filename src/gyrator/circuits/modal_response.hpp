#pragma once

#include "gyrator/circuits/state_space.hpp"

#include <array>
#include <complex>
#include <optional>
#include <vector>

namespace gyrator {

/// A state space with two inputs and one or two outputs as a sum over its modes,
///   G(s) = D + sum_i r_i/(s - p_i),                                            (modal-1)
/// the fastest form for the sums over aliases that a passivity verdict needs, and one whose
/// derivatives and whose reach between two frequencies are plain to see. p_i poles [rad/s], r_i
/// residues; entries of a 2 x 2 matrix row by row, those of a missing output zero.
class ModalResponse {
 public:
  using Entries = std::array<std::complex<double>, 4>;

  /// None where the modes do not reproduce the response: a pole that is (nearly) double and has
  /// too few eigenvectors. Checked against HessenbergResponse about every pole and upwards, real
  /// and imaginary parts by themselves, as far as highest() [rad/s]: far above its poles a response
  /// of high relative degree is a small difference between its modes.
  static std::optional<ModalResponse> find(const StateSpace& system);

  /// G(j omega).
  Entries at(double omega) const;

  const std::vector<std::complex<double>>& poles() const { return poles_; }
  /// Residue of an entry (row-major index) at the pole.
  std::complex<double> residue(std::size_t pole, std::size_t entry) const {
    return residues_[pole][entry];
  }
  double feedthrough(std::size_t entry) const { return feedthrough_[entry]; }
  double highest() const { return highest_; }

 private:
  std::vector<std::complex<double>> poles_;
  std::vector<Entries> residues_;
  std::array<double, 4> feedthrough_{};
  std::size_t entries_ = 4;  // that are not zero
  double highest_ = 0;
};

}  // namespace gyrator
