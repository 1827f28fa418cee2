#include "gyrator/studies/certificate_reader.hpp"

#include "gyrator/core/error.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace gyrator {
namespace {

using nlohmann::json;

std::string within(const std::string& place, const std::string& name) {
  return place.empty() ? name : place + "/" + name;
}

[[noreturn]] void refuse(const std::string& place, const std::string& message) {
  throw Error(ErrorCode::bad_input, place, message);
}

double number_of(const json& value, const std::string& place) {
  if (!value.is_number()) refuse(place, "a number is expected");
  const double number = value.get<double>();
  if (!std::isfinite(number)) refuse(place, "a finite number is expected");
  return number;
}

// A matrix without rows has no columns to show: `columns` says how many it would have.
Eigen::MatrixXd read_matrix(const json& object, const std::string& place, const char* name,
                            Eigen::Index rows, Eigen::Index columns) {
  const std::string here = within(place, name);
  const json& value = object[name];
  if (!value.is_array() || static_cast<Eigen::Index>(value.size()) != rows)
    refuse(here, fmt::format("{} rows are expected", rows));
  Eigen::MatrixXd matrix(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const json& row = value[static_cast<std::size_t>(i)];
    const std::string line = fmt::format("{}/{}", here, i);
    if (!row.is_array() || static_cast<Eigen::Index>(row.size()) != columns)
      refuse(line, fmt::format("{} numbers are expected", columns));
    for (Eigen::Index j = 0; j < columns; ++j) {
      matrix(i, j) = number_of(row[static_cast<std::size_t>(j)], fmt::format("{}/{}", line, j));
    }
  }
  return matrix;
}

Eigen::Index rows_of(const json& object, const std::string& place, const char* name) {
  if (!object[name].is_array()) refuse(within(place, name), "a list of rows is expected");
  return static_cast<Eigen::Index>(object[name].size());
}

StateSpace read_state_space(const json& object, const std::string& place, Eigen::Index inputs) {
  const Eigen::Index states = rows_of(object, place, "A");
  const Eigen::Index outputs = rows_of(object, place, "D");
  return {read_matrix(object, place, "A", states, states),
          read_matrix(object, place, "B", states, inputs),
          read_matrix(object, place, "C", outputs, states),
          read_matrix(object, place, "D", outputs, inputs)};
}

std::vector<CertifiedInterval> read_intervals(const json& loop, const std::string& loop_place) {
  const std::string place = within(loop_place, "intervals");
  const json& columns = loop["intervals"];
  require_members(columns, place,
                  {"omega", "reach", "law_real", "law_imag", "center_real", "center_imag", "radius",
                   "margin", "slope", "curvature"});
  const json& first = columns["omega"];
  std::vector<CertifiedInterval> intervals(first.is_array() ? first.size() : 0);
  const auto column = [&](const char* name, const auto& put) {
    const std::string here = within(place, name);
    const json& values = columns[name];
    if (!values.is_array() || values.size() != intervals.size())
      refuse(here, fmt::format("a list of {} numbers is expected", intervals.size()));
    for (std::size_t i = 0; i < intervals.size(); ++i)
      put(intervals[i], number_of(values[i], fmt::format("{}/{}", here, i)));
  };
  using I = CertifiedInterval;
  column("omega", [](I& i, double x) { i.omega = x; });
  column("reach", [](I& i, double x) { i.reach = x; });
  column("law_real", [](I& i, double x) { i.law.real(x); });
  column("law_imag", [](I& i, double x) { i.law.imag(x); });
  column("center_real", [](I& i, double x) { i.center.real(x); });
  column("center_imag", [](I& i, double x) { i.center.imag(x); });
  column("radius", [](I& i, double x) { i.radius = x; });
  column("margin", [](I& i, double x) { i.margin = x; });
  column("slope", [](I& i, double x) { i.slope = x; });
  column("curvature", [](I& i, double x) { i.curvature = x; });
  return intervals;
}

OperatorRefutation read_operator(const json& refutation, const std::string& place) {
  require_members(
      refutation, place,
      {"kind", "inertia", "damping", "stiffness", "resonators", "spectral_radius", "frequency_hz"});
  OperatorRefutation result;
  result.held_by.inertia = read_number(refutation, place, "inertia");
  result.held_by.damping = read_number(refutation, place, "damping");
  result.held_by.stiffness = read_number(refutation, place, "stiffness");
  result.spectral_radius = read_number(refutation, place, "spectral_radius");
  result.frequency_hz = read_number(refutation, place, "frequency_hz");
  const std::string hung = within(place, "resonators");
  if (!refutation["resonators"].is_array()) refuse(hung, "a list is expected");
  for (std::size_t i = 0; i < refutation["resonators"].size(); ++i) {
    const json& resonator = refutation["resonators"][i];
    const std::string here = fmt::format("{}/{}", hung, i);
    require_members(resonator, here, {"inertia", "stiffness"});
    result.held_by.resonators.push_back(
        {read_number(resonator, here, "inertia"), read_number(resonator, here, "stiffness")});
  }
  return result;
}

}  // namespace

void require_members(const json& object, const std::string& place,
                     std::initializer_list<const char*> names) {
  if (!object.is_object()) refuse(place, "an object is expected");
  for (const char* name : names) {
    if (!object.contains(name)) refuse(within(place, name), "is missing");
  }
  for (const auto& [name, value] : object.items()) {
    if (std::find(names.begin(), names.end(), name) == names.end())
      refuse(within(place, name), "is no field of a certificate");
  }
}

double read_number(const json& object, const std::string& place, const char* name) {
  return number_of(object[name], within(place, name));
}

std::string read_text(const json& object, const std::string& place, const char* name) {
  if (!object[name].is_string()) refuse(within(place, name), "a text is expected");
  return object[name];
}

HeldDevice read_held_device(const json& device) {
  const std::string place = "device";
  require_members(device, place, {"A", "B", "C", "D", "port_inertia"});
  return {read_state_space(device, place, 2), read_number(device, place, "port_inertia")};
}

DiscreteStateSpace read_law(const json& loop, const std::string& loop_place) {
  const std::string place = within(loop_place, "law");
  const json& law = loop["law"];
  require_members(law, place, {"A", "B", "C", "D"});
  if (rows_of(law, place, "D") != 1) refuse(within(place, "D"), "one number is expected");
  const StateSpace system = read_state_space(law, place, 1);
  return {system.A, system.B, system.C, system.D(0, 0)};
}

CertifiedLoop read_certified_loop(const json& loop, const std::string& place) {
  require_members(loop, place,
                  {"name", "law", "uncoupled_spectral_radius", "lowest_omega", "lowest_margin",
                   "direct_aliases", "bounded_aliases", "intervals"});
  for (const char* name : {"direct_aliases", "bounded_aliases"}) {
    if (!loop[name].is_number_integer() || loop[name] < 1)
      refuse(within(place, name), "a whole number above zero is expected");
  }
  if (loop["bounded_aliases"] < loop["direct_aliases"])
    refuse(within(place, "bounded_aliases"), "is less than direct_aliases");
  return {read_law(loop, place), read_number(loop, place, "uncoupled_spectral_radius"),
          read_number(loop, place, "lowest_omega"), read_number(loop, place, "lowest_margin"),
          read_intervals(loop, place)};
}

Refutation read_refutation(const json& loop, const std::string& loop_place) {
  require_members(loop, loop_place, {"name", "law", "refutation"});
  const std::string place = within(loop_place, "refutation");
  const json& refutation = loop["refutation"];
  if (!refutation.is_object() || !refutation.contains("kind"))
    refuse(within(place, "kind"), "is missing");
  const std::string kind = read_text(refutation, place, "kind");
  if (kind == "operator") return read_operator(refutation, place);
  if (kind == "uncoupled") {
    require_members(refutation, place, {"kind", "spectral_radius"});
    return UncoupledRefutation{read_number(refutation, place, "spectral_radius")};
  }
  if (kind == "device") {
    require_members(refutation, place, {"kind", "omega", "damping"});
    return DeviceRefutation{read_number(refutation, place, "omega"),
                            read_number(refutation, place, "damping")};
  }
  if (kind != "disk")
    refuse(within(place, "kind"), kind + ": must be operator, uncoupled, device or disk");
  require_members(
      refutation, place,
      {"kind", "omega", "law_real", "law_imag", "center_real", "center_imag", "radius", "margin"});
  const auto number = [&](const char* name) { return read_number(refutation, place, name); };
  return DiskRefutation{number("omega"),
                        {number("law_real"), number("law_imag")},
                        {number("center_real"), number("center_imag")},
                        number("radius"),
                        number("margin")};
}

}  // namespace gyrator
