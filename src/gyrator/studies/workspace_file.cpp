#include "gyrator/studies/workspace_file.hpp"

#include "gyrator/core/error.hpp"
#include "gyrator/core/quantity.hpp"
#include "gyrator/core/text.hpp"
#include "gyrator/documents/document_reader.hpp"
#include "gyrator/documents/json_text.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/core.h>

namespace gyrator {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using nlohmann::json;

[[noreturn]] void refuse(const std::string& place, const std::string& message) {
  throw Error(ErrorCode::bad_input, place, message);
}

// A joint or a direction may turn or slide: a damping in the units of either.
double read_damping(const json& value, const std::string& place) {
  if (value.is_number()) return value.get<double>();
  if (!value.is_string())
    refuse(place,
           value.dump() + ": a damping is expected, such as \"2 mN.m.s/rad\" or \"3 N.s/m\"");
  try {
    const Quantity given = parse_quantity(value.get<std::string>());
    const bool is_linear = given.dimension == dimension::linear_damping.dimension;
    return value_in(given, is_linear ? dimension::linear_damping : dimension::rotary_damping);
  } catch (const Error& error) {
    throw Error(error.code(), place, error.message() + " (or a linear damping [N.s/m])");
  }
}

double read_number(const json& value, const std::string& place) {
  if (!value.is_number()) refuse(place, value.dump() + ": a number in SI units is expected");
  return value.get<double>();
}

// Rows of numbers, all of one length.
template <class Read>
MatrixXd read_rows(const json& rows, const std::string& place, const Read& read) {
  if (!rows.is_array() || rows.empty() || !rows.front().is_array() || rows.front().empty())
    refuse(place, "a matrix is expected: a list of rows, such as [[1, 0], [0, 1]]");
  const auto columns = static_cast<Index>(rows.front().size());
  MatrixXd matrix(static_cast<Index>(rows.size()), columns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string row = fmt::format("{}/{}", place, i);
    if (!rows[i].is_array() || static_cast<Index>(rows[i].size()) != columns)
      refuse(row, fmt::format("a row of {} numbers is expected, as the first", columns));
    for (std::size_t j = 0; j < rows[i].size(); ++j)
      matrix(static_cast<Index>(i), static_cast<Index>(j)) =
          read(rows[i][j], fmt::format("{}/{}", row, j));
  }
  return matrix;
}

// One damping for all, one each, or all of a matrix; symmetric and not negative.
MatrixXd read_damping_matrix(const json& given, Index size, const std::string& place,
                             const char* of_what, bool positive) {
  MatrixXd matrix = MatrixXd::Zero(size, size);
  const auto check_size = [&](Index found) {
    if (found != size)
      refuse(place,
             fmt::format("{} for {} {}", describe_count(static_cast<std::size_t>(found), "damping"),
                         size, of_what));
  };
  if (!given.is_array()) {
    matrix.diagonal().setConstant(read_damping(given, place));
  } else if (!given.empty() && given.front().is_array()) {
    matrix = read_rows(given, place, read_damping);
    check_size(matrix.rows());
    check_size(matrix.cols());
    const double asymmetry = (matrix - matrix.transpose()).cwiseAbs().maxCoeff();
    if (asymmetry > 1e-9 * matrix.cwiseAbs().maxCoeff())
      refuse(place, "the matrix must be symmetric: of a damping only that part loses energy");
  } else {
    check_size(static_cast<Index>(given.size()));
    for (std::size_t i = 0; i < given.size(); ++i)
      matrix(static_cast<Index>(i), static_cast<Index>(i)) =
          read_damping(given[i], fmt::format("{}/{}", place, i));
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(matrix, Eigen::EigenvaluesOnly);
  const double least = solver.eigenvalues()(0);
  const double rounding = 1e-12 * matrix.cwiseAbs().maxCoeff();
  if (positive ? !(least > rounding) : !(least >= -rounding)) {
    refuse(place, fmt::format("its least eigenvalue is {:.6g}: must be {}", least,
                              positive ? "above 0, as every joint has some damping"
                                       : "at least 0, as a damping is"));
  }
  return matrix;
}

}  // namespace

const ObjectSpec& workspace_format() {
  static const ObjectSpec format{
      "workspace",
      "Joint damping and Jacobians of a mechanism, for `gyrator workspace`.",
      {
          member::choice("schema", {workspace_schema_name})
              .by_default(workspace_schema_name)
              .doc("Version of the format."),
          member::text("name").by_default("unnamed").doc("Shown in reports."),
          member::anything("joint_damping")
              .required()
              .doc("Of the joints: one number for all, a list, or a symmetric matrix; N.m.s/rad or "
                   "N.s/m."),
          member::anything("task_damping")
              .doc("That the environment needs at the hand, in the same three forms; N.s/m or "
                   "N.m.s/rad."),
          member::object("poses",
                         {"pose",
                          "Where the mechanism stands.",
                          {member::text("name").doc("By default its number."),
                           member::anything("jacobian")
                               .required()
                               .doc("Rows of numbers [SI]: velocity of the hand, in each of "
                                    "its directions, per velocity of each joint.")}})
              .list(1)
              .required()
              .doc("Of the workspace."),
      }};
  return format;
}

Workspace parse_workspace(const json& document, const std::string& file) {
  const json read = read_document(document, workspace_format(), file);
  Workspace workspace;
  workspace.name = read["name"];
  workspace.file = file;
  workspace.source = document;
  Index directions = 0;
  Index joints = 0;
  for (std::size_t i = 0; i < read["poses"].size(); ++i) {
    const json& pose = read["poses"][i];
    const std::string place = fmt::format("{}: /poses/{}/jacobian", file, i);
    workspace.poses.push_back(
        {pose["name"].is_null() ? fmt::format("{}", i + 1) : pose["name"].get<std::string>(),
         read_rows(pose["jacobian"], place, read_number)});
    const MatrixXd& jacobian = workspace.poses.back().jacobian;
    if (i == 0) {
      directions = jacobian.rows();
      joints = jacobian.cols();
    } else if (jacobian.rows() != directions || jacobian.cols() != joints) {
      refuse(place, fmt::format("{} x {}: must be {} x {}, directions x joints, as the first",
                                jacobian.rows(), jacobian.cols(), directions, joints));
    }
  }
  workspace.joint_damping =
      read_damping_matrix(read["joint_damping"], joints, file + ": /joint_damping", "joints", true);
  if (!read["task_damping"].is_null()) {
    workspace.task_damping =
        read_damping_matrix(read["task_damping"], directions, file + ": /task_damping",
                            "directions of the hand", false);
  }
  return workspace;
}

Workspace load_workspace(const std::string& path) {
  return parse_workspace(load_json_file(path), path);
}

}  // namespace gyrator
