#pragma once

#include "gyrator/circuits/network.hpp"

#include <complex>
#include <string>
#include <vector>

#include <Eigen/Dense>

namespace gyrator {

/// The network's equations in descriptor form, E dx/dt = A x + B u.            (mna-1)
///
/// x holds the across quantity of every node but the reference, then the through quantity of
/// every element that carries one as an unknown (sources, inductors, transformers); u the
/// inputs of the network. E is singular in general. Row i says what is summed to zero: the
/// through quantities leaving a node (Kirchhoff), or a branch's own law.
struct Descriptor {
  Eigen::MatrixXd E, A, B;
  std::vector<std::string> unknown_names;
  /// The elements each equation speaks of, for messages about a singular network.
  std::vector<std::vector<std::string>> equation_elements;

  Eigen::Index size() const { return A.rows(); }
};

/// A linear function of the unknowns and inputs: row_x x + row_u u.
struct LinearForm {
  Eigen::RowVectorXd x, u;
};

/// The network together with its equations; the forms name what can be read from them.
class NetworkEquations {
 public:
  explicit NetworkEquations(const Network& network);

  const Network& network() const { return network_; }
  const Descriptor& descriptor() const { return descriptor_; }

  LinearForm across(NodeId positive, NodeId negative = ground) const;
  LinearForm across(ElementId element) const;
  /// The through quantity, of any element but a capacitor (which would need dx/dt).
  /// Throws bad_input for one.
  LinearForm through(ElementId element) const;

 private:
  int branch_of(ElementId element) const {
    return branch_[static_cast<std::size_t>(element.index)];
  }
  void stamp(ElementId id);
  void stamp_flow(NodeId positive, NodeId negative, int column, double factor);
  void stamp_across(int row, NodeId positive, NodeId negative, double factor);

  Network network_;
  Descriptor descriptor_;
  std::vector<int> branch_;  ///< index of the branch unknown of each element, or -1
};

/// Frequency response straight from the descriptor, (sE - A)^-1 B, one column per input.
/// s in rad/s. Throws numerical where the pencil is singular at s.
/// For one frequency; DescriptorResponse is for many.
Eigen::MatrixXcd solve_descriptor(const Descriptor& descriptor, std::complex<double> s);

/// Throws the numerical error of a pencil that is singular at s, naming the elements around the
/// unknown that it leaves free.
[[noreturn]] void throw_singular_pencil(const std::vector<std::string>& elements,
                                        std::complex<double> s);

/// Steady state for constant inputs, 0 = A x + B u, one column per input. A part of x that
/// stays undetermined (a node between two capacitors) is set to zero; where no steady state
/// exists the column is not finite.
Eigen::MatrixXd solve_steady_state(const Descriptor& descriptor);

}  // namespace gyrator
