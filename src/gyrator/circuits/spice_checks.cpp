#include "gyrator/circuits/spice_checks.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/Dense>
#include <fmt/core.h>

namespace gyrator {
namespace {

[[noreturn]] void refuse(const std::string& place, std::string message) {
  throw Error(ErrorCode::bad_input, place, std::move(message));
}

template <class Law>
const Law* law_of(const SpiceElement& element) {
  return std::get_if<Law>(&element.law);
}

bool is_coupling(const SpiceElement& element) {
  return law_of<MutualInductance>(element) != nullptr;
}

// The nodes whose voltage an element listens to; none for a negative resistance, whose control
// is its own pair of terminals.
std::optional<std::pair<NodeId, NodeId>> find_control(const SpiceElement& element) {
  if (const auto* e = law_of<VoltageControlledVoltageSource>(element)) {
    return std::pair{e->control_positive, e->control_negative};
  }
  if (const auto* e = law_of<LimitedVoltageControlledVoltageSource>(element)) {
    return std::pair{e->control_positive, e->control_negative};
  }
  if (const auto* o = law_of<IdealOpAmp>(element)) {
    return std::pair{o->control_positive, o->control_negative};
  }
  const auto* g = law_of<VoltageControlledCurrentSource>(element);
  if (g == nullptr) return std::nullopt;
  const bool own =
      (g->control_positive == element.positive && g->control_negative == element.negative) ||
      (g->control_positive == element.negative && g->control_negative == element.positive);
  if (own) return std::nullopt;
  return std::pair{g->control_positive, g->control_negative};
}

// Carries a current that its own voltage says nothing about.
bool is_current_source(const SpiceElement& element) {
  if (law_of<CurrentControlledCurrentSource>(element) || law_of<CurrentSource>(element) ||
      law_of<ConstantCurrentSource>(element)) {
    return true;
  }
  return law_of<VoltageControlledCurrentSource>(element) && find_control(element);
}

// Has a voltage that its own current says nothing about.
bool is_voltage_source(const SpiceElement& element) {
  return law_of<VoltageSource>(element) || law_of<ConstantVoltageSource>(element) ||
         law_of<VoltageControlledVoltageSource>(element) ||
         law_of<LimitedVoltageControlledVoltageSource>(element) ||
         law_of<CurrentControlledVoltageSource>(element);
}

std::string describe(const std::vector<std::string>& names) {
  constexpr std::size_t most = 8;
  if (names.size() <= most) return join(names);
  return join({names.begin(), names.begin() + most}) +
         fmt::format(" and {} more", names.size() - most);
}

// Sets of nodes that grow together.
class Partition {
 public:
  explicit Partition(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int find(NodeId node) {
    int at = node.index;
    while (parent_[static_cast<std::size_t>(at)] != at) {
      int& parent = parent_[static_cast<std::size_t>(at)];
      parent = parent_[static_cast<std::size_t>(parent)];
      at = parent;
    }
    return at;
  }
  void unite(NodeId a, NodeId b) { parent_[static_cast<std::size_t>(find(a))] = find(b); }
  bool same(NodeId a, NodeId b) { return find(a) == find(b); }

 private:
  std::vector<int> parent_;
};

// A forest of ideal voltage sources, which knows the path between two of its nodes.
class SourceForest {
 public:
  explicit SourceForest(std::size_t nodes) : nodes_(nodes), edges_(nodes) {}

  bool connects(NodeId a, NodeId b) { return nodes_.same(a, b); }

  void add(NodeId a, NodeId b, const std::string& name) {
    nodes_.unite(a, b);
    edges_[static_cast<std::size_t>(a.index)].push_back({b, name});
    edges_[static_cast<std::size_t>(b.index)].push_back({a, name});
  }

  std::vector<std::string> find_path(NodeId from, NodeId to) const {
    std::map<int, std::pair<int, std::string>> reached{{from.index, {from.index, ""}}};
    std::vector<NodeId> front{from};
    for (std::size_t i = 0; i < front.size(); ++i) {
      for (const auto& [next, name] : edges_[static_cast<std::size_t>(front[i].index)]) {
        if (reached.emplace(next.index, std::pair{front[i].index, name}).second) {
          front.push_back(next);
        }
      }
    }
    std::vector<std::string> names;
    for (int at = to.index; at != from.index; at = reached.at(at).first) {
      if (!reached.at(at).second.empty()) names.push_back(reached.at(at).second);
    }
    return names;
  }

 private:
  struct Edge {
    NodeId to;
    std::string name;
  };
  Partition nodes_;
  std::vector<std::vector<Edge>> edges_;
};

class Structure {
 public:
  explicit Structure(const SpiceCircuit& circuit) : circuit_(circuit) {}

  void check() const {
    check_terminals();
    check_parts();
    build_forest(false);
  }

  void check_port() const {
    const SourceForest forest = build_forest(true);
    if (!forest_connects(forest)) return;
    refuse(
        circuit_.place,
        fmt::format("the terminals {} and {} of {} are shorted, or held by ideal voltage sources: "
                    "{}",
                    node_name(pin(1)), node_name(pin(2)), circuit_.name,
                    describe(forest.find_path(pin(1), pin(2)))));
  }

 private:
  static NodeId pin(int number) { return {number}; }
  static bool forest_connects(SourceForest forest) { return forest.connects(pin(1), pin(2)); }
  bool is_outside(NodeId node) const { return node.index <= circuit_.pin_count; }
  const std::string& node_name(NodeId node) const {
    return circuit_.nodes[static_cast<std::size_t>(node.index)];
  }

  std::vector<std::string> elements_at(NodeId node) const {
    std::vector<std::string> names;
    for (const SpiceElement& element : circuit_.elements) {
      if (is_coupling(element)) continue;
      const auto control = find_control(element);
      const bool touches = element.positive == node || element.negative == node ||
                           (control && (control->first == node || control->second == node));
      if (touches) names.push_back(element.name);
    }
    return names;
  }

  const std::string& place_at(NodeId node) const {
    const auto names = elements_at(node);
    const auto found =
        std::find_if(circuit_.elements.begin(), circuit_.elements.end(),
                     [&](const SpiceElement& e) { return !names.empty() && e.name == names[0]; });
    return found == circuit_.elements.end() ? circuit_.place : found->place;
  }

  void check_terminals() const {
    std::vector<int> terminals(circuit_.nodes.size());
    std::vector<int> listeners(circuit_.nodes.size());
    const auto count = [](std::vector<int>& counts, NodeId node) {
      ++counts[static_cast<std::size_t>(node.index)];
    };
    for (const SpiceElement& element : circuit_.elements) {
      if (is_coupling(element)) continue;
      count(terminals, element.positive);
      count(terminals, element.negative);
      if (const auto control = find_control(element)) {
        count(listeners, control->first);
        count(listeners, control->second);
      }
    }
    for (int index = 1; index < static_cast<int>(circuit_.nodes.size()); ++index) {
      const NodeId node{index};
      const int through = terminals[static_cast<std::size_t>(index)];
      const int all = through + listeners[static_cast<std::size_t>(index)];
      const std::string& name = node_name(node);
      if (is_outside(node)) {
        if (all == 0) {
          refuse(circuit_.place,
                 fmt::format("the pin {} of {} is connected to nothing", name, circuit_.name));
        }
        continue;
      }
      const bool intended = name.find("unconnected-") != std::string::npos && through == 1;
      if (all == 0 || intended) continue;  // without elements: left out
      if (through == 0) {
        refuse(place_at(node),
               fmt::format("floating node {}: {} listen to its voltage, and nothing "
                           "is connected to it",
                           name, describe(elements_at(node))));
      }
      if (all == 1) {
        refuse(place_at(node), fmt::format("floating node {}: only one terminal, of {}, reaches it",
                                           name, describe(elements_at(node))));
      }
    }
  }

  void check_parts() const {
    Partition parts(circuit_.nodes.size());
    for (int i = 1; i <= circuit_.pin_count; ++i) parts.unite(ground, {i});
    for (const SpiceElement& element : circuit_.elements) {
      if (!is_coupling(element) && !is_current_source(element)) {
        parts.unite(element.positive, element.negative);
      }
    }
    for (const SpiceElement& element : circuit_.elements) {
      if (is_coupling(element)) continue;
      for (const NodeId node : {element.positive, element.negative}) {
        if (!parts.same(node, ground)) check_island(parts, node);
      }
    }
  }

  // A part of the circuit that nothing but current sources connects to the rest.
  void check_island(Partition& parts, NodeId node) const {
    const auto inside = [&](NodeId other) { return parts.same(other, node); };
    std::vector<std::string> sources;
    std::vector<std::string> members;
    bool steered = false;
    for (const SpiceElement& element : circuit_.elements) {
      if (is_coupling(element)) continue;
      const bool leaves = inside(element.positive) != inside(element.negative);
      if (leaves) sources.push_back(element.name);
      if (!leaves && inside(element.positive)) members.push_back(element.name);
      const auto control = find_control(element);
      steered = steered || (control && inside(control->first) != inside(control->second));
    }
    if (sources.empty()) {
      refuse(place_at(node), fmt::format("no path from node {} to the terminals or ground: {}",
                                         node_name(node), describe(members)));
    }
    // A source that answers to the part's own voltage may well determine it.
    if (steered) return;
    refuse(place_at(node),
           fmt::format("a cut-set of current sources: only {} connect the part with "
                       "node {} to the rest, and its voltage is undetermined",
                       describe(sources), node_name(node)));
  }

  // With the port's second pin at ground where that is asked for. Throws at the first loop.
  SourceForest build_forest(bool second_pin_at_ground) const {
    SourceForest forest(circuit_.nodes.size());
    if (second_pin_at_ground) forest.add(pin(2), ground, "");
    for (const bool outputs : {false, true}) {
      // Op-amp outputs last: they adapt to whatever the others hold, but not to each other.
      for (const SpiceElement& element : circuit_.elements) {
        if (outputs ? !law_of<IdealOpAmp>(element) : !is_voltage_source(element)) continue;
        if (forest.connects(element.positive, element.negative)) {
          std::vector<std::string> members = forest.find_path(element.positive, element.negative);
          members.push_back(element.name);
          refuse(element.place,
                 fmt::format("a loop of ideal voltage sources or shorts: {}", describe(members)));
        }
        forest.add(element.positive, element.negative, element.name);
      }
      if (second_pin_at_ground) break;  // an op-amp may well drive the terminals
    }
    return forest;
  }

  const SpiceCircuit& circuit_;
};

// The matrix of coupling coefficients has to be positive semidefinite: the energy is i' L i / 2.
void check_couplings(const SpiceCircuit& circuit) {
  std::map<int, int> coils;  // element to row
  std::map<std::pair<int, int>, std::string> pairs;
  const auto row_of = [&](ElementId id) {
    return coils.emplace(id.index, static_cast<int>(coils.size())).first->second;
  };
  struct Entry {
    int row, column;
    double coefficient;
  };
  std::vector<Entry> entries;
  std::vector<std::string> names;
  const std::string* place = nullptr;
  for (const SpiceElement& element : circuit.elements) {
    const auto* k = law_of<MutualInductance>(element);
    if (k == nullptr) continue;
    const int a = std::min(k->first.index, k->second.index);
    const int b = std::max(k->first.index, k->second.index);
    const auto [known, is_new] = pairs.emplace(std::pair{a, b}, element.name);
    if (!is_new) {
      refuse(element.place, fmt::format("{} couples two inductors that {} couples already",
                                        element.name, known->second));
    }
    const auto inductance = [&](ElementId id) {
      return law_of<Inductor>(circuit.elements[static_cast<std::size_t>(id.index)])->inductance;
    };
    const double coefficient =
        k->inductance / std::sqrt(inductance(k->first) * inductance(k->second));
    entries.push_back({row_of(k->first), row_of(k->second), coefficient});
    names.push_back(element.name);
    place = &element.place;
  }
  if (entries.empty()) return;
  const auto size = static_cast<Eigen::Index>(coils.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(size, size);
  for (const Entry& entry : entries) {
    matrix(entry.row, entry.column) = entry.coefficient;
    matrix(entry.column, entry.row) = entry.coefficient;
  }
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly)
          .eigenvalues()(0);
  const double rounding = 1e-14 * static_cast<double>(size);
  if (least >= -rounding) return;
  refuse(*place,
         fmt::format("the couplings {} together could hold negative energy: no windings have "
                     "them (smallest eigenvalue {:g}, must not be negative)",
                     describe(names), least));
}

}  // namespace

void check_spice_structure(const SpiceCircuit& circuit) {
  Structure(circuit).check();
  check_couplings(circuit);
}

void check_spice_port(const SpiceCircuit& circuit) {
  Structure(circuit).check_port();
}

}  // namespace gyrator
