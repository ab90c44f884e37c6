// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/wall_faces.h"

namespace enfilade::slam {

std::vector<Eigen::Vector2d> OnFacesSeen(const SubmapGrid& grid, const LikelihoodField& field,
                                         const std::vector<Eigen::Vector2d>& points, const Pose2& T_submap_robot,
                                         double matched_distance) {
  constexpr double kBeside = 0.2;  // m, farther than noise and a blurred wall reach
  const auto is_free = [&](const Eigen::Vector2d& p_submap) { return grid.IsFree(grid.log_odds().CellOf(p_submap)); };
  std::vector<Eigen::Vector2d> facing;
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d p_submap = T_submap_robot * p;
    const Eigen::Vector2d beside = kBeside * (p_submap - T_submap_robot.translation()).normalized();
    const bool on_wall = field.At(p_submap).squared_distance <= matched_distance * matched_distance;
    if (on_wall && !is_free(p_submap - beside) && is_free(p_submap + beside)) continue;
    facing.push_back(p);
  }
  return facing;
}

}  // namespace enfilade::slam
