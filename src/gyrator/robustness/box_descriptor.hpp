#pragma once

#include "gyrator/mechanics/device.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// The device with these values of its parts. Its amplifier's gain must be set (Device::gain).
using DeviceMaker = std::function<Device(std::span<const double>)>;

/// Ranges of all parts, centre ± half, in the parts' units.
struct PartBox {
  std::vector<double> center, half;
};

/// The free device's equations (mna-1) over a box of its parts, one term per element:
///   E = sum_t e_t(d) u_t v_t^T      [A B_u] = [A_0 B_0] + sum_t a_t(d) u_t v_t^T,  |d_i| <= 1
///   e_t or a_t = value + sum_i slopes_i d_i ± remainder                                   (box-3)
/// The port's node is the last row and the last column but the command's, B_u: what its row says is
/// the effort from the operator. The port's own inertia is left out; it adds to Im Z alone.
struct BoxDescriptor {
  struct Term {
    Eigen::VectorXd row, column;  ///< u, v
    bool storage = false;         ///< of E
    double value = 0;             ///< at the centre; 0 for one of A
    std::vector<double> slopes;   ///< for each part
    double remainder = 0;
    unsigned parts = 0;  ///< those that it depends on, by bits
  };
  Eigen::MatrixXd E, A;  ///< at the centre, with the command's column
  std::vector<Term> terms;
  Eigen::RowVectorXd sensed;  ///< of the unknowns, port and command, the same for all parts
  bool collocated = true;
  std::size_t parts = 0;

  Eigen::Index inner() const { return E.rows() - 1; }  ///< unknowns but the port's
  /// The same with one part's range halved about its centre.
  BoxDescriptor with_half(std::size_t part) const;
};

/// Makes BoxDescriptors from the devices at the centre, the ends and the corners of boxes.
///
/// Entries are sums, products and quotients of parts. Of one part, g(d) = slope d + r(d) is convex
/// or concave; the slope is half the difference of both ends, so that r(0) = 0, r(1) = r(-1) = e
/// and |r| <= |e|. What two parts have together and not alone,
///   g(d_1, d_2) - g(d_1, 0) - g(0, d_2) + g(0, 0) = integral of d²g/(dd_1 dd_2),
/// is largest at a corner where that derivative keeps its sign, as it does in products of powers
/// and in 1/(R (1 + alpha h)) for |alpha h| < 1; likewise for three. (box-4)
class BoxDescriptorMaker {
 public:
  /// Finds which parts act together in the whole box. Throws bad_input where the equations are not
  /// the same throughout, or an operating point depends on the parts.
  BoxDescriptorMaker(DeviceMaker maker, const PartBox& whole);

  BoxDescriptor make(const PartBox& box) const;

 private:
  struct Equations {
    Eigen::MatrixXd E, A;  // as in BoxDescriptor
  };
  Equations build(std::span<const double> values) const;
  /// Inclusion and exclusion over the parts of `together`, moved from `from` by `to`.
  Equations find_joint(const std::vector<double>& from, const std::vector<double>& to,
                       const std::vector<std::size_t>& together) const;
  void find_joint_parts(const PartBox& whole);
  void add_single(BoxDescriptor& d, const PartBox& box, std::size_t part,
                  const Equations& center) const;
  void add_joint(BoxDescriptor& d, const PartBox& box,
                 const std::vector<std::size_t>& together) const;

  DeviceMaker maker_;
  std::vector<std::string> unknowns_;
  std::vector<std::vector<std::size_t>> together_;  // pairs and triples of parts
  Eigen::RowVectorXd sensed_;
  bool collocated_ = true;
};

}  // namespace gyrator
