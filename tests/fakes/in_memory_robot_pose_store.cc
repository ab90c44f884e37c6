// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/geometry/covariance.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/fakes/map_rows.h"

namespace enfilade::testing {

absl::Status InMemoryRobotPoseStore::Report(const storage::CallContext& context, const storage::RobotPose& pose) const {
  if (!IsFinite(pose.T_map_robot.pose)) return InvalidArgument("the pose is not finite");
  ENFILADE_RETURN_IF_ERROR(ValidateCovariance(pose.T_map_robot.covariance));
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_RETURN_IF_ERROR(access.GetMap(pose.site, pose.map).status());
  SiteRows* const rows = access.FindSite(pose.site);
  const rearrange::MapRedirect redirect = ResolveMap(*rows, pose.map);
  if (!rows->robots.contains(pose.robot)) return NotFound("{} does not exist", NameOf(pose.site, pose.robot));
  const auto stored = rows->robot_poses.find(pose.robot);
  if (stored != rows->robot_poses.end()) {
    const bool newer = stored->second.time < pose.time;
    const bool estimated_again = stored->second.time == pose.time && stored->second.session == pose.session;
    if (!newer && !estimated_again) return absl::OkStatus();
  }
  storage::RobotPose& row = rows->robot_poses[pose.robot];
  row = pose;
  row.map = redirect.to;
  row.T_map_robot = rearrange::Moved(redirect.T_to_from, pose.T_map_robot);
  row.version = access.NewEtag();
  return absl::OkStatus();
}

absl::StatusOr<storage::RobotPose> InMemoryRobotPoseStore::Get(const storage::CallContext& context, const SiteId& site,
                                                               const RobotId& robot) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  if (const SiteRows* const rows = access.FindSite(site)) {
    const auto found = rows->robot_poses.find(robot);
    if (found != rows->robot_poses.end()) return found->second;
  }
  return NotFound("a pose of {} does not exist", NameOf(site, robot));
}

absl::StatusOr<std::vector<storage::RobotPose>> InMemoryRobotPoseStore::List(const storage::CallContext& context,
                                                                             const SiteId& site) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<storage::RobotPose> poses;
  if (const SiteRows* const rows = access.FindSite(site)) {
    for (const auto& [robot, pose] : rows->robot_poses) poses.push_back(pose);
  }
  return poses;
}

}  // namespace enfilade::testing
