#pragma once

#include "gyrator/documents/document_spec.hpp"

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <nlohmann/json.hpp>

namespace gyrator {

/// The damping of a mechanism's joints, and what the hand needs, over its poses.
struct Workspace {
  std::string name, file;
  Eigen::MatrixXd joint_damping;                ///< symmetric, positive definite
  std::optional<Eigen::MatrixXd> task_damping;  ///< symmetric, positive semidefinite
  struct Pose {
    std::string name;
    Eigen::MatrixXd jacobian;  ///< task x joints
  };
  std::vector<Pose> poses;
  nlohmann::json source;  ///< as the user wrote it
};

/// The file's keys; a damping is a number for all, a list of one each, or a matrix.
const ObjectSpec& workspace_format();
inline constexpr const char* workspace_schema_name = "gyrator/workspace/1";

/// Throws bad_input with file and JSON pointer.
Workspace load_workspace(const std::string& path);
Workspace parse_workspace(const nlohmann::json& document, const std::string& file);

}  // namespace gyrator
