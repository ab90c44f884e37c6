// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/fakes/map_rows.h"

namespace enfilade::testing {

std::vector<absl::Status> InMemoryRobotPoseStore::ReportAll(const storage::CallContext& context,
                                                            const std::vector<storage::RobotPose>& poses) const {
  std::vector<absl::Status> answers;
  for (const storage::RobotPose& pose : poses) answers.push_back(ReportOne(context, pose));
  return answers;
}

absl::Status InMemoryRobotPoseStore::ReportOne(const storage::CallContext& context,
                                               const storage::RobotPose& report) const {
  ENFILADE_ASSIGN_OR_RETURN(const storage::RobotPose pose, storage::Receive(report));
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_RETURN_IF_ERROR(access.GetMap(pose.site, pose.map).status());
  SiteRows* const rows = access.FindSite(pose.site);
  const rearrange::MapRedirect redirect = ResolveMap(*rows, pose.map);
  if (!rows->robots.contains(pose.robot)) return NotFound("{} does not exist", NameOf(pose.site, pose.robot));
  const auto stored = rows->robot_poses.find(pose.robot);
  if (stored != rows->robot_poses.end() && !storage::Replaces(pose, stored->second)) return absl::OkStatus();
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
