#pragma once

#include "gyrator/circuits/drive.hpp"
#include "gyrator/core/quantity.hpp"
#include "gyrator/mechanics/device.hpp"

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// What a design chooses: something that is bought in steps, or set.
enum class DesignPart { resistor, capacitor, setting };

/// One number that a topology leaves to be chosen.
struct DesignVariable {
  std::string key;  ///< of the damping in a model file: "resistance"
  DesignPart part = DesignPart::setting;
  Unit unit;
  double (*low)(const Motor&) = nullptr;  ///< ends of the range if none is given, above zero
  double (*high)(const Motor&) = nullptr;
  std::string meaning;
};

/// A way of damping a motor that `gyrator design` knows: one row of list_topologies().
struct Topology {
  std::string name;            ///< the damping's kind in a model file: "rc"
  bool voltage_drive = false;  ///< needs a voltage amplifier, else one that sets the current
  std::vector<DesignVariable> variables;
  Damping (*make)(const Motor&, std::span<const double>) = nullptr;
};

/// All of them; another one is a row here.
const std::vector<Topology>& list_topologies(Motion motion);

/// "rc.resistance", the name of a variable in ranges and results.
std::string name_of(const Topology& topology, const DesignVariable& variable);

}  // namespace gyrator
