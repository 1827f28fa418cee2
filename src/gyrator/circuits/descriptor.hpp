#pragma once

#include "gyrator/circuits/network.hpp"
#include "gyrator/circuits/nonlinear_law.hpp"

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
  /// Nonlinear elements have their slope at the operating point, and constant sources are at rest:
  /// the equations of small deviations from it. Throws as find_operating_point().
  explicit NetworkEquations(const Network& network);

  /// The whole network for large signals. Nonlinear elements have their companion, what is left of
  /// their laws are inputs of their own, and one more input is 1 and drives the constant sources:
  /// u = [inputs of the network; one per port; 1].
  static NetworkEquations with_ports(const Network& network);

  /// With a given slope of each element's law (those of linear ones are not looked at).
  static NetworkEquations with_slopes(const Network& network, const std::vector<double>& slopes);

  const Network& network() const { return network_; }
  const Descriptor& descriptor() const { return descriptor_; }
  /// In the order of their elements; none unless made by with_ports().
  const std::vector<NonlinearPort>& ports() const { return ports_; }

  LinearForm across(NodeId positive, NodeId negative = ground) const;
  LinearForm across(ElementId element) const;
  /// The through quantity, of any element but a capacitor (which would need dx/dt).
  /// Throws bad_input for one.
  LinearForm through(ElementId element) const;
  /// What a nonlinear element's law is a function of.
  LinearForm argument(ElementId element) const;

 private:
  NetworkEquations(const Network& network, std::vector<double> slopes, bool ported);
  void stamp_port(ElementId id);
  int branch_of(ElementId element) const {
    return branch_[static_cast<std::size_t>(element.index)];
  }
  void stamp(ElementId id);
  void stamp_flow(NodeId positive, NodeId negative, int column, double factor);
  void stamp_input_flow(NodeId positive, NodeId negative, int input, double factor);
  void stamp_across(int row, NodeId positive, NodeId negative, double factor);

  Network network_;
  Descriptor descriptor_;
  std::vector<int> branch_;     ///< index of the branch unknown of each element, or -1
  std::vector<double> slopes_;  ///< of each nonlinear element
  std::vector<NonlinearPort> ports_;
  std::vector<int> port_input_;  ///< column of each element's port, or -1
  int constant_input_ = -1;      ///< column of the constant sources, or -1
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
