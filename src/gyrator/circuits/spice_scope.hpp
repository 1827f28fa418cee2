#pragma once

#include "gyrator/circuits/spice_expression.hpp"
#include "gyrator/circuits/spice_lines.hpp"

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrator {

/// A parameter as its file states it: `.param name=text`, or a default on a `.subckt` line.
struct SpiceParameter {
  std::string name;  ///< lower case
  std::string text;
  std::string place;
};

/// The parameters that one subcircuit sees: its own, then those of the scope around it.
///
/// Values are computed when they are asked for, so that parameters may refer to each other in any
/// order.
class SpiceScope {
 public:
  /// `outer` must outlive this scope.
  explicit SpiceScope(SpiceScope* outer = nullptr) : outer_(outer) {}

  /// Adds a parameter. Throws bad_input where this scope has one of the name already.
  void define(const SpiceParameter& parameter);

  /// Gives a parameter a value that goes before its definition, which may be missing.
  void override_value(const std::string& name, double value, const std::string& place);

  /// The value of an expression in this scope. Throws bad_input naming a cycle of parameters, or an
  /// unknown parameter and the nearest known one.
  double evaluate(std::string_view text, const std::string& place);

  /// A value that was given from outside but has no definition and was never asked for.
  std::optional<std::string> find_useless_override() const;

  /// Names visible here, the innermost first.
  std::vector<std::string> names() const;

 private:
  struct Entry {
    SpiceParameter parameter;
    std::optional<double> value;
    bool overridden = false;
    bool defined = false;
    bool used = false;
    bool busy = false;  ///< being computed: asking again is a cycle
  };

  double evaluate(std::string_view text, const std::string& place, std::vector<std::string>& path);
  double find_value(const std::string& name, const std::string& place,
                    std::vector<std::string>& path);

  SpiceScope* outer_;
  std::map<std::string, Entry> entries_;
};

}  // namespace gyrator
