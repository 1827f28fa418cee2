#pragma once

#include "gyrator/circuits/spice_reader.hpp"
#include "gyrator/circuits/spice_scope.hpp"
#include "gyrator/circuits/spice_subcircuit.hpp"

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// One use of a subcircuit while its lines are read.
struct SpiceInstance {
  const SpiceDefinition* definition = nullptr;
  SpiceInstance* around = nullptr;  ///< of the definition that this one's stands in
  SpiceInstance* caller = nullptr;  ///< whose X line this is
  std::string prefix;               ///< of the names inside: "x1.x2."
  SpiceScope scope;
  std::map<std::string, NodeId> nodes;
};

/// A `.model` line and the instance whose definition holds it.
struct SpiceModelUse {
  const SpiceModel* model = nullptr;
  SpiceInstance* around = nullptr;
};

/// Puts a circuit together, element by element, instance by instance.
class SpiceBuilder {
 public:
  /// `deck` must outlive the builder.
  SpiceBuilder(const SpiceDeck& deck, const SpiceReadOptions& options);

  /// The whole of one subcircuit of the deck, or of what stands outside of any.
  SpiceCircuit build(const SpiceDefinition& definition);

  // For the lines of the elements (spice_elements.cpp):

  const SpiceReadOptions& options() const { return options_; }
  NodeId find_node(SpiceInstance& instance, std::string_view name);
  NodeId add_node(std::string name, const std::string& place);
  /// Throws bad_input where the name is taken.
  void add(SpiceElement element);
  /// An F or H whose law takes the current of the V source `control`, given as its instance's
  /// prefix and its name, before or after it in the file.
  void add_controlled(SpiceElement element, const std::string& prefix, std::string_view control);
  /// Couples every two of the inductors.
  void add_coupling(const std::string& name, const std::string& place, const std::string& prefix,
                    const std::vector<std::string>& inductors, double coupling);
  /// The model that a name means in an instance. Throws bad_input with the nearest name.
  SpiceModelUse find_model(const SpiceCard& card, const std::string& name,
                           SpiceInstance& instance) const;
  /// An X line: its nodes and the subcircuit's name, and the parameters that it overrides.
  void add_instance(const SpiceCard& card, SpiceInstance& caller);

 private:
  struct Control {
    SpiceElement element;
    std::string prefix, source;
  };
  struct Coupling {
    std::string name, place, prefix;
    std::vector<std::string> inductors;
    double coefficient;
  };

  void read_lines(SpiceInstance& instance);
  static void override_parameters(const SpiceCard& card, SpiceInstance& caller,
                                  SpiceInstance& instance);
  /// The definition that a name means in an instance, and the instance around it.
  SpiceInstance find_definition(const SpiceCard& card, const std::string& name,
                                SpiceInstance& caller);
  template <class... Laws>
  int find_reference(const std::string& place, const std::string& prefix, const std::string& name,
                     std::string_view letter, std::string_view what) const;
  std::string describe_missing_libraries() const;
  void resolve(Control control);
  void resolve(const Coupling& coupling);

  const SpiceDeck& deck_;
  SpiceReadOptions options_;
  SpiceCircuit circuit_;
  std::map<std::string, int> index_;  ///< of the elements, by name
  std::vector<Control> controls_;
  std::vector<Coupling> couplings_;
  std::size_t instances_ = 0;
};

}  // namespace gyrator
