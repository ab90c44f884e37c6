// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/robot/agent/state_machine.h"
#include "nlohmann/json.hpp"

namespace enfilade::robot {

// A command as a person types it: a word and its arguments, such as `set-candidate`, `set-link-point lift 2`, `existing
// "Hall A" 1.5 2 90`. The names of map_manager's services are accepted, too; "_" stands for "-". `covariance`: of a
// pose that is given without one. INVALID_ARGUMENT saying what is expected.
absl::StatusOr<Command> ParseCommand(std::string_view line, const Eigen::Matrix3d& covariance);

// The same as an object {"type":"command","command":WORD,...} with the members place, level, map, link_point, pose
// (x_m, y_m, yaw_rad) and covariance (9 numbers, row by row).
absl::StatusOr<Command> CommandFromJson(const nlohmann::json& object, const Eigen::Matrix3d& covariance);

// x_m, y_m, yaw_rad of the member `name`. INVALID_ARGUMENT.
absl::StatusOr<Pose2> PoseFromJson(const nlohmann::json& object, const std::string& name);
// The member "covariance", or `otherwise` if it is missing.
absl::StatusOr<Eigen::Matrix3d> CovarianceFromJson(const nlohmann::json& object, const Eigen::Matrix3d& otherwise);

// All commands, one a line.
std::string CommandHelp();

}  // namespace enfilade::robot
