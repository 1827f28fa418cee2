#include "gyrator/circuits/modal_response.hpp"

#include "gyrator/circuits/hessenberg_response.hpp"
#include "gyrator/core/plain_complex.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace gyrator {
namespace {

using Complex = std::complex<double>;

// Whether the modes give what the state space does, each entry to `floor` of its own at worst.
// Where one of real and imaginary part is much the smaller, it has to be right by itself: a real
// part may be a damping.
bool agrees(const ModalResponse::Entries& found, const Eigen::MatrixXcd& expected,
            const Eigen::MatrixXd& floor) {
  constexpr double agreement = 1e-12;
  constexpr double agreement_of_parts = 1e-10;
  for (Eigen::Index r = 0; r < expected.rows(); ++r) {
    for (Eigen::Index c = 0; c < expected.cols(); ++c) {
      const Complex error = found[static_cast<std::size_t>(2 * r + c)] - expected(r, c);
      const double size = std::abs(expected(r, c));
      if (!(std::abs(error) <= agreement * size + floor(r, c))) return false;
      const double part = std::abs(expected(r, c).real());
      if (!(std::abs(error.real()) <= agreement_of_parts * part + 1e-15 * size + floor(r, c)))
        return false;
    }
  }
  return true;
}

}  // namespace

std::optional<ModalResponse> ModalResponse::find(const StateSpace& system) {
  ModalResponse modal;
  const Eigen::Index outputs = system.C.rows();
  const Eigen::Index inputs = system.B.cols();
  modal.entries_ = static_cast<std::size_t>(2 * outputs);
  for (Eigen::Index r = 0; r < outputs; ++r) {
    for (Eigen::Index c = 0; c < inputs; ++c)
      modal.feedthrough_[static_cast<std::size_t>(2 * r + c)] = system.D(r, c);
  }
  if (system.A.rows() == 0) {
    modal.highest_ = std::numeric_limits<double>::infinity();
    return modal;
  }
  Eigen::MatrixXd A = system.A;
  const Eigen::VectorXd scale = balance(A);
  const Eigen::EigenSolver<Eigen::MatrixXd> modes(A);
  if (modes.info() != Eigen::Success) return std::nullopt;
  const Eigen::MatrixXcd V = modes.eigenvectors();
  const Eigen::PartialPivLU<Eigen::MatrixXcd> inverse(V);
  const Eigen::MatrixXcd input =
      inverse.solve((scale.cwiseInverse().asDiagonal() * system.B).cast<Complex>());
  const Eigen::MatrixXcd output = (system.C * scale.asDiagonal()).cast<Complex>() * V;

  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    modal.poles_.push_back(modes.eigenvalues()(i));
    Entries residue{};
    for (Eigen::Index r = 0; r < outputs; ++r) {
      for (Eigen::Index c = 0; c < inputs; ++c)
        residue[static_cast<std::size_t>(2 * r + c)] = output(r, i) * input(i, c);
    }
    modal.residues_.push_back(residue);
  }
  HessenbergResponse direct(system);
  double fastest = 0;
  std::vector<double> checked;
  std::vector<Eigen::MatrixXcd> expected;
  Eigen::MatrixXd floor = Eigen::MatrixXd::Zero(outputs, inputs);
  for (const Complex& pole : modal.poles_) {
    const double size = std::abs(pole);
    fastest = std::max(fastest, size);
    for (const double factor : {0.01, 0.7, 1.0, 1.6}) {
      if (size == 0) continue;
      checked.push_back(factor * size);
      direct.evaluate(Complex(0, checked.back()), expected.emplace_back());
      floor = floor.cwiseMax(1e-14 * expected.back().cwiseAbs());  // next to a zero
    }
  }
  for (std::size_t i = 0; i < checked.size(); ++i) {
    if (!agrees(modal.at(checked[i]), expected[i], floor)) return std::nullopt;
  }
  modal.highest_ = 1.6 * fastest;
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(outputs, inputs);
  Eigen::MatrixXcd above;
  while (modal.highest_ < 1e5 * fastest) {
    const double omega = 1.5 * modal.highest_;
    direct.evaluate(Complex(0, omega), above);
    if (!agrees(modal.at(omega), above, none)) break;
    modal.highest_ = omega;
  }
  return modal;
}

ModalResponse::Entries ModalResponse::at(double omega) const {
  std::array<double, 4> real = feedthrough_;
  std::array<double, 4> imag{};
  for (std::size_t i = 0; i < poles_.size(); ++i) {
    // 1/(jw - p) = (-Re p - j(w - Im p)) / |jw - p|^2
    const double a = -poles_[i].real();
    const double b = omega - poles_[i].imag();
    const double size = 1 / (a * a + b * b);
    const double x = a * size;
    const double y = -b * size;
    for (std::size_t k = 0; k < entries_; ++k) {
      const Complex r = residues_[i][k];
      real[k] += r.real() * x - r.imag() * y;
      imag[k] += r.real() * y + r.imag() * x;
    }
  }
  Entries entries;
  for (std::size_t k = 0; k < 4; ++k) entries[k] = {real[k], imag[k]};
  return entries;
}

}  // namespace gyrator
