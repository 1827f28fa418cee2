#include "gyrator/regression/figure_check.hpp"

#include "gyrator/core/text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

std::string with_unit(const std::string& text, const std::string& unit) {
  return unit.empty() || unit == "1" ? text : text + " " + unit;
}

// As few digits as tell the two apart.
std::string describe_beside(double number, double neighbour) {
  for (int digits = 6; digits < 17; ++digits) {
    std::string text = fmt::format("{:.{}g}", number, digits);
    if (number == neighbour || text != fmt::format("{:.{}g}", neighbour, digits)) return text;
  }
  return format_number(number);
}

std::string describe_change(double value, double reference) {
  const double change = value - reference;
  if (reference == 0)
    return fmt::format("{:.3g} {}", std::abs(change), change < 0 ? "lower" : "higher");
  const double share = std::abs(change / reference);
  const std::string text = fmt::format("{:.3g} %", 100 * share);
  return text + (change < 0 ? " lower" : " higher");
}

// How far beyond what is allowed, 1 at the limit; infinite where the values cannot be compared.
struct Comparison {
  double excess = 0;
  std::string reason;
  std::optional<std::size_t> item;
};

class Comparer {
 public:
  Comparer(const FigureTolerance& tolerance, std::string unit, std::string what)
      : tolerance_(tolerance), unit_(std::move(unit)), what_(std::move(what)) {}

  Comparison compare(const json& value, const json& reference) const {
    if (value.is_number() && reference.is_number())
      return compare_numbers(value.get<double>(), reference.get<double>());
    if (value.is_array() && reference.is_array()) {
      if (value.size() != reference.size()) {
        return differ(fmt::format("{}, {} {}", describe_count(value.size(), "value"), what_,
                                  reference.size()));
      }
      Comparison worst;
      for (std::size_t i = 0; i < value.size(); ++i) {
        Comparison item = compare(value[i], reference[i]);
        if (item.excess <= worst.excess) continue;
        item.reason = fmt::format("[{}]: {}", i, item.reason);
        item.item = i;
        worst = std::move(item);
      }
      return worst;
    }
    if (value == reference) return {};
    const bool lost = value.is_null() && reference.is_number();
    return differ(fmt::format("{}, {} {}",
                              lost ? "no number any more" : describe_figure(value, unit_), what_,
                              describe_figure(reference, unit_)));
  }

 private:
  static Comparison differ(std::string reason) {
    return {std::numeric_limits<double>::infinity(), std::move(reason), {}};
  }

  Comparison compare_numbers(double value, double reference) const {
    const double allowed = tolerance_.absolute + tolerance_.relative * std::abs(reference);
    const double change = value - reference;
    if (tolerance_.side == Side::below && change >= 0) return {};
    if (tolerance_.side == Side::above && change <= 0) return {};
    if (std::abs(change) <= allowed) return {};
    const double excess =
        allowed > 0 ? std::abs(change) / allowed : std::numeric_limits<double>::infinity();
    return {std::isnan(excess) ? std::numeric_limits<double>::infinity() : excess,
            fmt::format("{}, {} {} {}: {}", with_unit(describe_beside(value, reference), unit_),
                        what_, with_unit(describe_beside(reference, value), unit_),
                        describe_tolerance(tolerance_, unit_), describe_change(value, reference)),
            {}};
  }

  const FigureTolerance& tolerance_;
  std::string unit_, what_;
};

bool is_fixed(const Expectation& expectation) {
  return expectation.is_none || !expectation.equals.is_null() || expectation.at_least ||
         expectation.at_most;
}

std::optional<std::string> find_single_violation(const json& value,
                                                 const Expectation& expectation) {
  const std::string now = describe_figure(value, expectation.unit);
  if (expectation.is_none && !value.is_null()) return fmt::format("{}: none is expected", now);
  if (!expectation.equals.is_null() && value != expectation.equals)
    return fmt::format("{}: {} is expected", now,
                       describe_figure(expectation.equals, expectation.unit));
  if (!expectation.at_least && !expectation.at_most) return std::nullopt;
  if (!value.is_number()) return fmt::format("{}: a number is expected", now);
  const double number = value.get<double>();
  // Written so that what is no number does not pass.
  if (expectation.at_least && !(number >= *expectation.at_least))
    return fmt::format("{}: at least {} is expected", now,
                       with_unit(describe_beside(*expectation.at_least, number), expectation.unit));
  if (expectation.at_most && !(number <= *expectation.at_most))
    return fmt::format("{}: at most {} is expected", now,
                       with_unit(describe_beside(*expectation.at_most, number), expectation.unit));
  return std::nullopt;
}

}  // namespace

std::optional<Difference> find_difference(const json& value, const json& reference,
                                          const FigureTolerance& tolerance, const std::string& unit,
                                          const std::string& what) {
  const Comparison worst = Comparer(tolerance, unit, what).compare(value, reference);
  if (worst.reason.empty()) return std::nullopt;
  return Difference{worst.reason, worst.item};
}

std::optional<Difference> find_violation(const json& value, const Expectation& expectation) {
  const bool each = value.is_array() && !expectation.equals.is_array();
  if (!each) {
    if (auto reason = find_single_violation(value, expectation)) return Difference{*reason, {}};
    return std::nullopt;
  }
  // Otherwise an answer that has lost its list would keep whatever is expected of the items.
  if (value.empty() && is_fixed(expectation))
    return Difference{"an empty list: at least one value is expected", {}};
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (value[i].is_array()) {
      if (auto inner = find_violation(value[i], expectation))
        return Difference{fmt::format("[{}]{}{}", i, inner->item ? "" : ": ", inner->reason), i};
    } else if (auto reason = find_single_violation(value[i], expectation)) {
      return Difference{fmt::format("[{}]: {}", i, *reason), i};
    }
  }
  return std::nullopt;
}

std::string describe_figure(const json& value, const std::string& unit) {
  constexpr std::size_t most_items = 4;
  if (value.is_number()) return with_unit(fmt::format("{:.6g}", value.get<double>()), unit);
  if (value.is_string()) return value.get<std::string>();
  if (value.is_null()) return "none";
  if (!value.is_array()) return value.dump(-1, ' ', false, json::error_handler_t::replace);
  std::vector<std::string> items;
  for (std::size_t i = 0; i < std::min(most_items, value.size()); ++i)
    items.push_back(describe_figure(value[i], ""));
  if (value.size() > most_items) items.push_back(fmt::format("… {} in all", value.size()));
  return with_unit("[" + join(items) + "]", unit);
}

std::string describe_tolerance(const FigureTolerance& tolerance, const std::string& unit) {
  if (tolerance.absolute == 0 && tolerance.relative == 0) return "exactly";
  const std::string sign = tolerance.side == Side::both    ? "±"
                           : tolerance.side == Side::below ? "-"
                                                           : "+";
  std::vector<std::string> parts;
  if (tolerance.absolute != 0)
    parts.push_back(sign + " " + with_unit(format_number(tolerance.absolute), unit));
  if (tolerance.relative != 0)
    parts.push_back(fmt::format("{} {:.4g} %", sign, 100 * tolerance.relative));
  return join(parts, " ");
}

}  // namespace gyrator
