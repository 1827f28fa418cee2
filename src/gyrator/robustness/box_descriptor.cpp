#include "gyrator/robustness/box_descriptor.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/robustness/rank_one_terms.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double rounding = 1e-13;  // of an entry, in what is left of differences

std::vector<Index> order_port_last(Index size, Index port) {
  std::vector<Index> order;
  for (Index i = 0; i < size; ++i) {
    if (i != port) order.push_back(i);
  }
  order.push_back(port);
  return order;
}

unsigned bits_of(const std::vector<std::size_t>& parts) {
  unsigned bits = 0;
  for (const std::size_t i : parts) bits |= 1U << i;
  return bits;
}

}  // namespace

BoxDescriptor BoxDescriptor::with_half(std::size_t part) const {
  BoxDescriptor halved = *this;
  for (Term& term : halved.terms) {
    if ((term.parts >> part & 1U) == 0) continue;
    term.slopes[part] /= 2;
    term.remainder *= std::has_single_bit(term.parts) ? 0.25 : 0.5;
  }
  return halved;
}

BoxDescriptorMaker::BoxDescriptorMaker(DeviceMaker maker, const PartBox& whole)
    : maker_(std::move(maker)) {
  const DeviceNetwork device = build_device_network(maker_(whole.center), FreeOperator{});
  for (const Element& element : device.network.elements()) {
    if (!std::holds_alternative<ConstantVoltageSource>(element.law) &&
        !std::holds_alternative<ConstantCurrentSource>(element.law))
      continue;
    throw Error(ErrorCode::bad_input, element.name,
                "a constant source, whose operating point moves with the parts: no guarantee over "
                "a box of them; leave it out, or rely on the samples");
  }
  const NetworkEquations equations(device.network);
  unknowns_ = equations.descriptor().unknown_names;
  const LinearForm sensed = find_sensed_rate(device, equations);
  const auto size = sensed.x.size();
  sensed_.resize(size + 1);
  sensed_.head(size) = sensed.x(order_port_last(size, device.port.index - 1));
  sensed_(size) = sensed.u(device.command);
  collocated_ = device.collocated;
  find_joint_parts(whole);
}

BoxDescriptorMaker::Equations BoxDescriptorMaker::build(std::span<const double> values) const {
  const DeviceNetwork device = build_device_network(maker_(values), FreeOperator{});
  const NetworkEquations equations(device.network);
  const Descriptor& d = equations.descriptor();
  if (d.unknown_names != unknowns_) {
    throw Error(ErrorCode::bad_input, "tolerances",
                "somewhere in the box a part vanishes (an inductance or resistance of 0), which no "
                "guarantee over the box can cross: let its range end above 0");
  }
  const Index size = d.size();
  const std::vector<Index> order = order_port_last(size, device.port.index - 1);
  Equations result{MatrixXd::Zero(size, size + 1), MatrixXd(size, size + 1)};
  result.E.leftCols(size) = d.E(order, order);
  result.E(size - 1, size - 1) = 0;
  result.A.leftCols(size) = d.A(order, order);
  result.A.col(size) = d.B.col(device.command)(order);
  return result;
}

BoxDescriptorMaker::Equations BoxDescriptorMaker::find_joint(
    const std::vector<double>& from, const std::vector<double>& to,
    const std::vector<std::size_t>& together) const {
  Equations sum;
  const unsigned all = 1U << together.size();
  for (unsigned moved = 0; moved < all; ++moved) {
    std::vector<double> at = from;
    for (std::size_t k = 0; k < together.size(); ++k) {
      if ((moved >> k & 1U) != 0) at[together[k]] = to[together[k]];
    }
    const Equations one = build(at);
    const bool minus = (together.size() - static_cast<std::size_t>(std::popcount(moved))) % 2 != 0;
    if (moved == 0) sum = {MatrixXd::Zero(one.E.rows(), one.E.cols()), 0 * one.A};
    sum.E += (minus ? -1 : 1) * one.E;
    sum.A += (minus ? -1 : 1) * one.A;
  }
  const Equations center = build(from);
  const auto clean = [&](MatrixXd& joint, const MatrixXd& scale) {
    joint = (joint.array().abs() > rounding * scale.array().abs()).select(joint, 0.0);
  };
  clean(sum.E, center.E);
  clean(sum.A, center.A);
  return sum;
}

// Looked at from a point that is nothing special: alpha times rise shows nothing at a rise of 0.
void BoxDescriptorMaker::find_joint_parts(const PartBox& whole) {
  const std::size_t parts = whole.center.size();
  std::vector<double> from, to;
  for (std::size_t i = 0; i < parts; ++i) {
    const double place = 0.3 + 0.4 * std::fmod(0.6180339887 * static_cast<double>(i + 1), 1.0);
    from.push_back(whole.center[i] + place * whole.half[i]);
    to.push_back(whole.center[i] - whole.half[i]);
  }
  const auto acts = [&](const std::vector<std::size_t>& together) {
    const Equations joint = find_joint(from, to, together);
    return !joint.E.isZero(0) || !joint.A.isZero(0);
  };
  for (std::size_t i = 0; i < parts; ++i) {
    for (std::size_t j = i + 1; j < parts; ++j) {
      if (!acts({i, j})) continue;
      together_.push_back({i, j});
      for (std::size_t k = j + 1; k < parts; ++k) {
        if (!acts({i, j, k})) continue;
        together_.push_back({i, j, k});
        for (std::size_t l = k + 1; l < parts; ++l) {
          if (!acts({i, j, k, l})) continue;
          throw Error(ErrorCode::bad_input, "tolerances",
                      "four toleranced quantities in one element: a guarantee has at most three");
        }
      }
    }
  }
}

BoxDescriptor BoxDescriptorMaker::make(const PartBox& box) const {
  const Equations center = build(box.center);
  BoxDescriptor d{center.E, center.A, {}, sensed_, collocated_, box.center.size()};
  for (const RankOne& element : split_rank_one({center.E}))
    d.terms.push_back({element.row, element.column, true, element.factors[0],
                       std::vector<double>(d.parts), 0, 0});
  for (std::size_t i = 0; i < d.parts; ++i) add_single(d, box, i, center);
  for (const auto& together : together_) add_joint(d, box, together);
  return d;
}

void BoxDescriptorMaker::add_single(BoxDescriptor& d, const PartBox& box, std::size_t part,
                                    const Equations& center) const {
  std::vector<double> values = box.center;
  values[part] = box.center[part] - box.half[part];
  const Equations low = build(values);
  values[part] = box.center[part] + box.half[part];
  const Equations high = build(values);
  const auto add = [&](const MatrixXd& below, const MatrixXd& above, const MatrixXd& middle,
                       bool storage) {
    const MatrixXd bend = (above + below) / 2 - middle;
    const MatrixXd floor = rounding * middle.cwiseAbs();
    const auto clean = [&](const MatrixXd& a) -> MatrixXd {
      return (a.array().abs() > floor.array()).select(a, 0.0);
    };
    for (const RankOne& element : split_rank_one({clean((above - below) / 2), clean(bend)})) {
      BoxDescriptor::Term term{element.row,
                               element.column,
                               storage,
                               0,
                               std::vector<double>(d.parts),
                               std::abs(element.factors[1]),
                               1U << part};
      term.slopes[part] = element.factors[0];
      d.terms.push_back(std::move(term));
    }
  };
  add(low.E, high.E, center.E, true);
  add(low.A, high.A, center.A, false);
}

void BoxDescriptorMaker::add_joint(BoxDescriptor& d, const PartBox& box,
                                   const std::vector<std::size_t>& together) const {
  std::vector<MatrixXd> storage, rest;
  for (unsigned corner = 0; corner < 1U << together.size(); ++corner) {
    std::vector<double> to = box.center;
    for (std::size_t k = 0; k < together.size(); ++k)
      to[together[k]] += ((corner >> k & 1U) != 0 ? 1 : -1) * box.half[together[k]];
    Equations joint = find_joint(box.center, to, together);
    storage.push_back(std::move(joint.E));
    rest.push_back(std::move(joint.A));
  }
  const auto add = [&](const std::vector<MatrixXd>& corners, bool is_storage) {
    for (const RankOne& element : split_rank_one(corners)) {
      double largest = 0;
      for (const double factor : element.factors) largest = std::max(largest, std::abs(factor));
      d.terms.push_back({element.row, element.column, is_storage, 0, std::vector<double>(d.parts),
                         largest, bits_of(together)});
    }
  };
  add(storage, true);
  add(rest, false);
}

}  // namespace gyrator
