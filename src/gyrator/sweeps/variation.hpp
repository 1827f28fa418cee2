#pragma once

#include "gyrator/documents/document_member.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace gyrator {

/// How a value of the model varies, as written: values one by one, or a range.
struct VariationText {
  std::string place;  ///< for messages: "--vary damping.0.capacitance", "study.json: /vary/0"
  std::string path;   ///< "damping.0.capacitance"
  std::vector<nlohmann::json> values;
  std::optional<nlohmann::json> from, to;  ///< of a range, where `values` is empty
  std::size_t points = 0;                  ///< of a range on a grid; 0: not given
  bool logarithmic = false;
};

/// Reads "PATH=FROM..TO:N", "PATH=FROM..TO:Nlog" or "PATH=a,b,c"; N may be left out where the
/// points are not on a grid. Throws bad_input, at --vary, for anything else.
VariationText parse_variation(std::string_view text);

/// The entry of a study file that says the same: {"path", "values"} or {"path", "from", "to",
/// "points", "scale"}.
nlohmann::json describe_variation(const VariationText& text);

/// One of the values of a variation.
struct SweepValue {
  nlohmann::json given;  ///< what stands in the model, in normal form
  double number = 0;     ///< in the unit; of a key that is no number, nothing
  std::string text;      ///< of a key that is no number
};

/// A value of the model with all that it may be.
///   range on a grid      v_k = from + (to - from) k/(N - 1)                          (sweep-1)
///   with `log`           v_k = from (to/from)^(k/(N - 1))                            (sweep-2)
///   at a share u         the same with u in place of k/(N - 1); of a list of n values the one with
///                        the number floor(u n)                                       (sweep-3)
/// The ends are met exactly. Of a range, times are rounded to whole nanoseconds (the simulator's
/// clock is exact) and, on a grid, whole numbers to the nearest one. At a share each of the n whole
/// numbers of a range has the same part of it: from + floor(u n); with `log` the number v has the
/// part from v to v + 1 of the range from |from| to |to| + 1.
class Variation {
 public:
  /// `normal` is the model in normal form, `format` its table. Throws bad_input, at the text's
  /// place, for what find_member refuses, a wrong dimension, ends of which only one has a unit, and
  /// values that the model's format does not allow.
  Variation(VariationText text, const nlohmann::json& normal, const Member& format);

  const std::string& path() const { return text_.path; }
  const VariationText& text() const { return text_; }
  const nlohmann::json::json_pointer& pointer() const { return found_.pointer; }
  bool is_number() const;
  /// "F"; "1" for a pure number, empty for what is no number.
  std::string unit() const;

  /// Throws bad_input for a range without a number of points.
  std::size_t count_grid_points() const;
  SweepValue at_grid(std::size_t index) const;
  SweepValue at_share(double share) const;

 private:
  SweepValue read(const nlohmann::json& value) const;
  SweepValue read_number(const nlohmann::json& value) const;
  SweepValue make_in_range(double share) const;
  SweepValue make_whole(double share) const;
  void read_range();
  void check(const SweepValue& value, nlohmann::json normal, const Member& format) const;
  [[noreturn]] void refuse(const std::string& message) const;

  VariationText text_;
  FoundMember found_;
  std::vector<SweepValue> values_;
  double from_ = 0, to_ = 0;
};

}  // namespace gyrator
