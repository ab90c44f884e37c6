// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/robot_pose_store.h"

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/link_point_rows.h"

namespace enfilade::storage::postgres {
namespace {

// As Replaces.
constexpr Statement kReport{
    "storing the robot's pose",
    "INSERT INTO enfilade.robot_poses AS p (site_id, robot_id, map_id, session_id, point, yaw, covariance, time_ns,"
    " received_ns) VALUES ($1, $2, $3, $4, ST_MakePointM($5, $6, $8::bigint / 1e9), $7, $9, $8, $10)"
    " ON CONFLICT (site_id, robot_id) DO UPDATE SET map_id = excluded.map_id, session_id = excluded.session_id,"
    " point = excluded.point, yaw = excluded.yaw, covariance = excluded.covariance, time_ns = excluded.time_ns,"
    " received_ns = excluded.received_ns, version = excluded.version"
    " WHERE least(p.time_ns, p.received_ns) < least(excluded.time_ns, excluded.received_ns)"
    " OR (p.time_ns = excluded.time_ns AND p.session_id IS NOT DISTINCT FROM excluded.session_id)"};
#define ENFILADE_ROBOT_POSE_COLUMNS \
  "site_id, robot_id, map_id, session_id, ST_X(point), ST_Y(point), yaw, covariance, time_ns, version, received_ns"
constexpr Statement kSelectRobotPose{"reading the robot's pose", "SELECT " ENFILADE_ROBOT_POSE_COLUMNS
                                                                 " FROM enfilade.robot_poses"
                                                                 " WHERE site_id = $1 AND robot_id = $2"};
constexpr Statement kListRobotPoses{"listing robots' poses",
                                    "SELECT " ENFILADE_ROBOT_POSE_COLUMNS
                                    " FROM enfilade.robot_poses WHERE site_id = $1 ORDER BY robot_id"};

RobotPose ReadRobotPose(Row& row) {
  RobotPose pose;
  pose.site = SiteId(std::string(row.Text()));
  pose.robot = RobotId(std::string(row.Text()));
  pose.map = MapId(std::string(row.Text()));
  if (const auto session = row.OptionalText()) pose.session = SessionId(std::string(*session));
  pose.T_map_robot.pose = {row.Double(), row.Double(), row.Double()};
  pose.T_map_robot.covariance = ReadCovariance(row);
  pose.time = row.Int64();
  pose.version = row.Int64();
  pose.received = row.Int64();
  return pose;
}

}  // namespace

absl::Status RobotPoseStore::Report(const CallContext& context, const RobotPose& report) const {
  ENFILADE_ASSIGN_OR_RETURN(const RobotPose pose, Receive(report));
  const Pose2& T_map_robot = pose.T_map_robot.pose;
  const auto stored =
      ExecuteAlone(pool_, context, kReport,
                   Params(pose.site, pose.robot, pose.map, pose.session, T_map_robot.x, T_map_robot.y, T_map_robot.yaw,
                          pose.time, ToRow(pose.T_map_robot.covariance), pose.received));
  const std::string constraint = ConstraintOf(stored.status());
  if (constraint == "robot_poses_site_id_map_id_fkey")
    return NotFound("{} does not exist", NameOf(pose.site, pose.map));
  if (constraint == "robot_poses_site_id_robot_id_fkey") {
    return NotFound("{} does not exist", NameOf(pose.site, pose.robot));
  }
  return WithContext(stored.status(), NameOf(pose.site, pose.robot));
}

absl::StatusOr<RobotPose> RobotPoseStore::Get(const CallContext& context, const SiteId& site,
                                              const RobotId& robot) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectRobotPose, Params(site, robot)));
  return ReadOne(result, ReadRobotPose, "a pose of " + NameOf(site, robot));
}

absl::StatusOr<std::vector<RobotPose>> RobotPoseStore::List(const CallContext& context, const SiteId& site) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kListRobotPoses, Params(site)));
  return ReadRows(result, ReadRobotPose);
}

}  // namespace enfilade::storage::postgres
