#pragma once

#include "gyrator/documents/document_spec.hpp"
#include "gyrator/studies/model_file.hpp"
#include "gyrator/synthesis/operating_extremes.hpp"
#include "gyrator/synthesis/preferred_values.hpp"
#include "gyrator/synthesis/topology.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

inline constexpr const char* design_schema_name = "gyrator/design/1";

/// What a design is good or bad in; a constraint bounds one of them. The worst over the winding's
/// temperatures each.
struct DesignFigures {
  bool stable = false;            ///< alone, with the port free and held
  bool has_limits = false;        ///< false: missed a constraint that is cheaper to judge
  double max_stiffness = 0;       ///< exact disk; mean over the virtual dampings, 0: none
  double least_stiffness = 0;     ///< the same, lowest of the virtual dampings
  double worst_frequency_hz = 0;  ///< where the lowest binds
  double apparent_inertia = 0;    ///< that the circuit adds below its corner [kg.m^2, kg]
  double emphasis_gain = 1;       ///< largest |F| of the pre-emphasis up to Nyquist
  double damping_below_5_hz = 0;  ///< largest Re Z up to 5 Hz, the device's own included
  OperatingExtremes extremes;
};

/// One figure that can be bounded; list_bounded_figures() has all.
struct BoundedFigure {
  const char* name;
  Unit unit;
  bool is_minimum;  ///< bounded from below
  bool is_extreme;  ///< needs the operation
  double (*value)(const DesignFigures&);
  const char* meaning;
};
const std::vector<BoundedFigure>& list_bounded_figures(Motion motion);

struct DesignConstraint {
  const BoundedFigure* figure = nullptr;
  double limit = 0;
};

enum class DesignObjective {
  stiffest,  ///< largest max_stiffness
  lightest   ///< least apparent inertia with a wall of given stiffness
};

struct DesignRange {
  double low = 0, high = 0;
};

/// One number that is left to be chosen: of a circuit, or of the controller.
struct SoughtValue {
  std::string name;  ///< in ranges and results: "rc.resistance", "digital.velocity_cutoff"
  DesignPart part = DesignPart::setting;
  Unit unit;
  DesignRange range;
};

/// One way that a spec leaves open: what is decided, and which numbers are then to be found.
struct DesignOption {
  const Topology* topology = nullptr;
  bool pre_emphasis = false;
  bool velocity_filter = false;     ///< the cut-off is sought, the last of `values`
  std::vector<SoughtValue> values;  ///< the topology's variables first
};
inline constexpr const char* velocity_cutoff_name = "digital.velocity_cutoff";
inline constexpr const char* pre_emphasis_name = "digital.pre_emphasis";

/// A design as asked for, validated.
struct DesignSpec {
  std::string file;  ///< for messages
  Model model;       ///< with the dampings that the design leaves alone
  DesignObjective objective = DesignObjective::stiffest;
  std::vector<double> damping;  ///< virtual dampings B, rising
  std::vector<DesignOption> options;
  std::optional<PreferredSeries> series;  ///< none: parts of any value
  std::vector<DesignConstraint> constraints;
  Operation operation;
  std::optional<DesignRange> winding_rise;  ///< temperatures of the winding [K]
  std::map<DesignPart, double> tolerances;  ///< relative, of what is bought
  bool bipolar_capacitor = true;            ///< false: two polarised ones back to back
  double rated_share = 0.9;                 ///< of max_stiffness, that a design promises
  std::size_t samples = 1000;               ///< for the yield
  std::size_t count = 3;                    ///< of designs to report
  std::uint64_t seed = 1;
  nlohmann::json source;  ///< as the user wrote it
};

/// The spec's keys, one table for each motion; reader, JSON Schema and manual follow.
const Member& design_format();

/// Throws bad_input with file and JSON pointer. The model's path is relative to the spec's file.
DesignSpec load_design_spec(const std::string& path);

/// The same from JSON that would stand in that file.
DesignSpec parse_design_spec(const nlohmann::json& document, const std::string& path);

/// The model with this damping added, the drive that the topology needs and the controller's
/// settings, as a model file.
nlohmann::json make_designed_model(const DesignSpec& spec, const DesignOption& option,
                                   const std::vector<nlohmann::json>& values);

/// Whether the options differ in their pre-emphasis, or have any.
bool mentions_pre_emphasis(const DesignSpec& spec);

}  // namespace gyrator
