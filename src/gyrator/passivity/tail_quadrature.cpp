#include "gyrator/passivity/tail_quadrature.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <boost/math/quadrature/gauss.hpp>

namespace gyrator {
namespace {

// Edges of the tail's quadrature panels, in ln w: even ones, and close ones about every resonance.
std::vector<double> make_panels(double from, double to, const Eigen::VectorXcd& poles) {
  constexpr double widest = 0.6;
  std::vector<double> edges;
  const auto count = static_cast<int>(std::ceil(std::log(to / from) / widest));
  for (int i = 0; i <= count; ++i)
    edges.push_back(std::log(from) + i * std::log(to / from) / count);
  for (const auto& pole : poles) {
    if (!is_resonance(pole) || pole.imag() < 0) continue;
    for (const double widths : {-9.0, -3.0, -1.0, 0.0, 1.0, 3.0, 9.0}) {
      const double edge = pole.imag() + widths * std::abs(pole.real());
      if (edge > from && edge < to) edges.push_back(std::log(edge));
    }
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

bool is_resonance(std::complex<double> pole) {
  return std::abs(pole.imag()) > 0.3 * std::abs(pole);
}

int count_resonant_aliases(const Eigen::VectorXcd& poles, double sampling_frequency) {
  constexpr double smooth_width = 4;  // in sampling frequencies
  constexpr double most = 1e6 - 1;
  double fastest = 0;
  for (const auto& pole : poles) {
    const bool narrow = std::abs(pole.real()) < smooth_width * sampling_frequency;
    if (is_resonance(pole) && narrow) fastest = std::max(fastest, std::abs(pole));
  }
  return static_cast<int>(std::min(2 * fastest / sampling_frequency, most)) + 1;
}

double find_tail_end(double from, const Eigen::VectorXcd& poles) {
  return 1e3 * std::max(from, poles.size() > 0 ? poles.cwiseAbs().maxCoeff() : 0.0);
}

std::vector<TailNode> make_tail_nodes(double from, double to, const Eigen::VectorXcd& poles) {
  using Rule = boost::math::quadrature::gauss<double, 8>;
  std::vector<TailNode> nodes;
  // In t = ln w the integrand is g/w.
  const std::vector<double> edges = make_panels(from, to, poles);
  for (std::size_t p = 0; p + 1 < edges.size(); ++p) {
    if (!(edges[p + 1] > edges[p])) continue;
    const double middle = (edges[p] + edges[p + 1]) / 2;
    const double half = (edges[p + 1] - edges[p]) / 2;
    for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
      for (const double side : {-1.0, 1.0}) {
        const double omega = std::exp(middle + side * half * Rule::abscissa()[i]);
        nodes.push_back({omega, half * Rule::weights()[i] / omega});
      }
    }
  }
  return nodes;
}

}  // namespace gyrator
