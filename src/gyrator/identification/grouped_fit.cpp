#include "gyrator/identification/grouped_fit.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/core.h>

namespace gyrator {
namespace {

constexpr int scale_rounds = 3;

struct Normal {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};

// Columns of unlike units: scaled to a diagonal of one before they are solved.
Eigen::VectorXd solve(const Normal& normal) {
  const Eigen::VectorXd scale = normal.matrix.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.cwiseInverse();
  const Eigen::MatrixXd even = inverse.asDiagonal() * normal.matrix * inverse.asDiagonal();
  return inverse.asDiagonal() *
         even.completeOrthogonalDecomposition().solve(inverse.asDiagonal() * normal.right);
}

std::map<int, Normal> build_normals(std::span<const Equation> equations,
                                    const std::vector<double>& scale) {
  const Eigen::Index unknowns = equations.front().x.size();
  std::map<int, Normal> normals;
  for (const Equation& e : equations) {
    Normal& normal = normals[e.group];
    if (normal.matrix.size() == 0) {
      normal.matrix = Eigen::MatrixXd::Zero(unknowns, unknowns);
      normal.right = Eigen::VectorXd::Zero(unknowns);
    }
    const double weight = 1 / std::pow(e.deviation * scale[static_cast<std::size_t>(e.family)], 2);
    normal.matrix += weight * e.x * e.x.transpose();
    normal.right += weight * e.y * e.x;
  }
  return normals;
}

Normal sum_of(const std::map<int, Normal>& normals) {
  Normal sum = normals.begin()->second;
  for (auto it = std::next(normals.begin()); it != normals.end(); ++it) {
    sum.matrix += it->second.matrix;
    sum.right += it->second.right;
  }
  return sum;
}

std::vector<double> find_scales(std::span<const Equation> equations, const Eigen::VectorXd& values,
                                std::size_t families) {
  std::vector<double> squares(families, 0.0), counts(families, 0.0);
  for (const Equation& e : equations) {
    const auto family = static_cast<std::size_t>(e.family);
    squares[family] += std::pow((e.y - e.x.dot(values)) / e.deviation, 2);
    counts[family] += 1;
  }
  std::vector<double> scale(families, 1.0);
  // A perfect fit must not give infinite weights.
  for (std::size_t f = 0; f < families; ++f)
    if (counts[f] > 0) scale[f] = std::max(std::sqrt(squares[f] / counts[f]), 1e-9);
  return scale;
}

}  // namespace

Estimate GroupedFit::at(int unknown) const {
  return {values[unknown], std::sqrt(covariance(unknown, unknown)),
          degrees[static_cast<std::size_t>(unknown)]};
}

GroupedFit build_jackknife(const Eigen::VectorXd& all,
                           const std::vector<Eigen::VectorXd>& without) {
  const auto groups = static_cast<double>(without.size());
  GroupedFit fit;
  fit.values = all;
  fit.groups = static_cast<int>(without.size());
  // As many values as groups leave no errors to see.
  const auto unknowns = static_cast<double>(all.size());
  const double share =
      jackknife_allowance * jackknife_allowance * (groups - 1) / std::max(groups - unknowns, 1.0);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(all.size());
  for (const Eigen::VectorXd& values : without) mean += values / groups;
  fit.covariance = Eigen::MatrixXd::Zero(all.size(), all.size());
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(all.size());
  for (const Eigen::VectorXd& values : without) {
    const Eigen::VectorXd off = values - mean;
    fit.covariance += share * off * off.transpose();
    squares += off.cwiseAbs2().cwiseAbs2();
  }
  for (Eigen::Index i = 0; i < all.size(); ++i) {
    const double sum = fit.covariance(i, i) / share;
    const double degrees = squares[i] > 0 ? 3 * sum * sum / squares[i] - 1 : groups - 1;
    fit.degrees.push_back(std::clamp(degrees, 1.0, groups - 1));
  }
  return fit;
}

GroupedFit fit_grouped(std::span<const Equation> equations) {
  const std::size_t unknowns = equations.empty() ? 0 : equations.front().x.size();
  if (equations.size() < unknowns + 1)
    throw Error(ErrorCode::numerical, "least squares",
                fmt::format("{} equations for {} unknowns: too few", equations.size(), unknowns));
  std::size_t families = 0;
  for (const Equation& e : equations)
    families = std::max(families, static_cast<std::size_t>(e.family) + 1);
  std::vector<double> scale(families, 1.0);
  Eigen::VectorXd values;
  for (int round = 0; round < scale_rounds; ++round) {
    values = solve(sum_of(build_normals(equations, scale)));
    scale = find_scales(equations, values, families);
  }
  const std::map<int, Normal> normals = build_normals(equations, scale);
  if (normals.size() < 3)
    throw Error(ErrorCode::numerical, "least squares",
                fmt::format("{} groups: at least 3 tell how sure a value is", normals.size()));
  const Normal sum = sum_of(normals);
  std::vector<Eigen::VectorXd> without;
  for (const auto& [group, normal] : normals)
    without.push_back(solve({sum.matrix - normal.matrix, sum.right - normal.right}));
  GroupedFit fit = build_jackknife(solve(sum), without);
  fit.scale = scale;
  return fit;
}

}  // namespace gyrator
