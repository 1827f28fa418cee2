#include "gyrator/circuits/state_space.hpp"
#include "gyrator/core/error.hpp"
#include "gyrator/cosim/engine.hpp"
#include "gyrator/cosim/step_ladder.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace gyrator {
namespace {

// Each segment is one matrix on z = [ξ; u], and each energy one quadratic form of z: nothing is
// approximated but the rounding of the exponentials.
class ExactEngine final : public Engine {
 public:
  ExactEngine(const Plant& plant, const EngineOptions& options)
      : Engine(plant),
        plant_(plant),
        ledger_(options.ledger),
        n_(plant.states()),
        z_(plant.states() + 2) {}

  int prepare(double interval) override {
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      if (segments_[i].interval == interval) return static_cast<int>(i);
    }
    segments_.push_back(make_segment(interval));
    return static_cast<int>(segments_.size()) - 1;
  }

  void advance(int number, double /*time*/, const Eigen::Vector2d& u, PlantState& state) override {
    move(segments_[static_cast<std::size_t>(number)], u, state);
  }

  void advance_once(double interval, double /*time*/, const Eigen::Vector2d& u,
                    PlantState& state) override {
    if (!(interval > 0)) return;
    if (!ladder_) make_ladder(interval);
    z_ << state.xi, u;
    StepLadder::Work work{};
    ladder_->travel(interval, z_, work);
    state.xi = z_.head(n_);
    state.operator_work += work[0];
    state.source_work += work[1];
    state.dissipated += work[2];
  }

 private:
  // For lengths that come only once: no exponential is made for each.
  void make_ladder(double interval) {
    for (const Segment& segment : segments_) interval = std::max(interval, segment.interval);
    Eigen::MatrixXd rate(n_, n_ + 2);
    rate << plant_.A, plant_.B;
    std::vector<Eigen::MatrixXd> forms;
    const auto& e = plant_.energy;
    if (ledger_) forms = {e.operator_work, e.source, e.dissipated};
    ladder_ = std::make_unique<StepLadder>(rate, forms, interval);
  }

  struct Segment {
    double interval;
    Eigen::MatrixXd propagate;                          // [phi gamma]
    Eigen::Matrix<double, 3, Eigen::Dynamic> energies;  // packed upper triangles
  };

  Segment make_segment(double interval) const {
    const HeldStep step = discretize_held(plant_.A, plant_.B, interval);
    Segment segment{interval, Eigen::MatrixXd(n_, n_ + 2), {}};
    segment.propagate << step.phi, step.gamma;
    if (ledger_) {
      const Eigen::Index size = n_ + 2;
      const auto& e = plant_.energy;
      segment.energies.resize(3, size * (size + 1) / 2);
      const auto integrals = integrate_quadratic_forms(
          plant_.A, plant_.B, {e.operator_work, e.source, e.dissipated}, interval);
      for (Eigen::Index row = 0; row < 3; ++row) {
        segment.energies.row(row) = pack(integrals[static_cast<std::size_t>(row)]);
      }
    }
    return segment;
  }

  void move(const Segment& segment, const Eigen::Vector2d& u, PlantState& state) {
    const Eigen::Index size = n_ + 2;
    double* z = z_.data();
    for (Eigen::Index i = 0; i < n_; ++i) z[i] = state.xi(i);
    z[n_] = u(0);
    z[n_ + 1] = u(1);
    if (ledger_) book(segment, z, size, state);

    double* next = state.xi.data();
    const double* column = segment.propagate.data();
    for (Eigen::Index i = 0; i < n_; ++i) next[i] = column[i] * z[0];
    for (Eigen::Index j = 1; j < size; ++j) {
      column += n_;
      const double zj = z[j];
      for (Eigen::Index i = 0; i < n_; ++i) next[i] += column[i] * zj;
    }
  }

  // Upper triangle row by row, off-diagonal entries doubled, so that z'Wz = sum of w_ij z_i z_j.
  static Eigen::RowVectorXd pack(const Eigen::MatrixXd& form) {
    Eigen::RowVectorXd packed(form.rows() * (form.rows() + 1) / 2);
    Eigen::Index at = 0;
    for (Eigen::Index i = 0; i < form.rows(); ++i) {
      for (Eigen::Index j = i; j < form.cols(); ++j)
        packed(at++) = i == j ? form(i, i) : form(i, j) + form(j, i);
    }
    return packed;
  }

  static void book(const Segment& segment, const double* z, Eigen::Index size, PlantState& state) {
    const double* w = segment.energies.data();
    double operator_work = 0;
    double source = 0;
    double dissipated = 0;
    for (Eigen::Index i = 0; i < size; ++i) {
      for (Eigen::Index j = i; j < size; ++j, w += 3) {
        const double product = z[i] * z[j];
        operator_work += w[0] * product;
        source += w[1] * product;
        dissipated += w[2] * product;
      }
    }
    state.operator_work += operator_work;
    state.source_work += source;
    state.dissipated += dissipated;
  }

  const Plant plant_;
  bool ledger_;
  Eigen::Index n_;
  Eigen::VectorXd z_;
  std::vector<Segment> segments_;
  std::unique_ptr<StepLadder> ladder_;
};

}  // namespace

std::unique_ptr<Engine> make_exact_engine(const Plant& plant, const EngineOptions& options) {
  if (plant.nonlinear) {
    for (const NonlinearPort& port : plant.nonlinear->ports) {
      if (is_piecewise_linear(port.law)) continue;
      throw Error(ErrorCode::bad_input, "engine",
                  "exact: the element " + port.element +
                      " is neither linear nor linear in pieces: use cvode");
    }
    return make_hybrid_engine(plant, options);
  }
  return std::make_unique<ExactEngine>(plant, options);
}

}  // namespace gyrator
