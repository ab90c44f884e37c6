// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/robot_pose_store.h"

#include <map>
#include <string_view>
#include <utility>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/link_point_rows.h"

namespace enfilade::storage::postgres {
namespace {

// As Replaces, for one pose of each robot. The maps are locked in order, and before the poses, so that reports wait for
// rearrangements and deletions of maps and not the other way round. Gives the poses whose robot or map is missing.
constexpr Statement kReport{
    "storing robots' poses",
    "WITH locked AS MATERIALIZED ("
    "  SELECT m.map_id FROM enfilade.maps m WHERE m.site_id = $1 AND m.map_id = ANY ($3) ORDER BY m.map_id"
    "  FOR KEY SHARE),"
    " given AS MATERIALIZED ("
    "  SELECT u.n, u.robot_id, u.map_id, nullif(u.session_id, '') AS session_id, u.x, u.y, u.yaw, u.time_ns,"
    "    u.received_ns, ($10::float8[])[u.n::integer * 9 - 8 : u.n::integer * 9] AS covariance,"
    "    EXISTS (SELECT FROM enfilade.robots o WHERE o.site_id = $1 AND o.robot_id = u.robot_id) AS has_robot,"
    "    EXISTS (SELECT FROM locked l WHERE l.map_id = u.map_id) AS has_map"
    "  FROM unnest($2::text[], $3::text[], $4::text[], $5::float8[], $6::float8[], $7::float8[], $8::bigint[],"
    "    $9::bigint[]) WITH ORDINALITY AS u (robot_id, map_id, session_id, x, y, yaw, time_ns, received_ns, n)),"
    " stored AS ("
    "  INSERT INTO enfilade.robot_poses AS p (site_id, robot_id, map_id, session_id, point, yaw, covariance, time_ns,"
    "    received_ns)"
    "  SELECT $1, g.robot_id, g.map_id, g.session_id, ST_MakePointM(g.x, g.y, g.time_ns / 1e9), g.yaw, g.covariance,"
    "    g.time_ns, g.received_ns FROM given g WHERE g.has_robot AND g.has_map ORDER BY g.robot_id"
    "  ON CONFLICT (site_id, robot_id) DO UPDATE SET map_id = excluded.map_id, session_id = excluded.session_id,"
    "   point = excluded.point, yaw = excluded.yaw, covariance = excluded.covariance, time_ns = excluded.time_ns,"
    "   received_ns = excluded.received_ns, version = excluded.version"
    "   WHERE least(p.time_ns, p.received_ns) < least(excluded.time_ns, excluded.received_ns)"
    "   OR (p.time_ns = excluded.time_ns AND p.session_id IS NOT DISTINCT FROM excluded.session_id))"
    " SELECT g.n, g.has_map FROM given g WHERE NOT (g.has_robot AND g.has_map)"};
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

// A report that is not yet answered, and the place of its answer.
struct OpenReport {
  RobotPose pose;
  absl::Status* answer;
};

absl::Status MissingMap(const RobotPose& pose) { return NotFound("{} does not exist", NameOf(pose.site, pose.map)); }
absl::Status MissingRobot(const RobotPose& pose) {
  return NotFound("{} does not exist", NameOf(pose.site, pose.robot));
}

absl::StatusOr<Result> StorePoses(Pool& pool, const CallContext& context, const std::vector<OpenReport>& reports) {
  std::vector<std::string_view> robots, maps, sessions;
  std::vector<double> x, y, yaw, covariances;
  std::vector<std::int64_t> times, received;
  for (const OpenReport& report : reports) {
    const RobotPose& pose = report.pose;
    robots.push_back(pose.robot.value());
    maps.push_back(pose.map.value());
    sessions.push_back(pose.session ? std::string_view(pose.session->value()) : std::string_view());
    x.push_back(pose.T_map_robot.pose.x);
    y.push_back(pose.T_map_robot.pose.y);
    yaw.push_back(pose.T_map_robot.pose.yaw);
    for (const double value : ToRow(pose.T_map_robot.covariance)) covariances.push_back(value);
    times.push_back(pose.time);
    received.push_back(pose.received);
  }
  return ExecuteAlone(
      pool, context, kReport,
      Params(reports.front().pose.site, robots, maps, sessions, x, y, yaw, times, received, covariances));
}

absl::Status AnswerReports(const Result& missing, const std::vector<OpenReport>& reports) {
  for (int i = 0; i < missing.rows(); ++i) {
    Row row(missing, i);
    const std::int64_t n = row.Int64();
    const bool has_map = row.Bool();
    ENFILADE_RETURN_IF_ERROR(row.status());
    const OpenReport& report = reports.at(static_cast<std::size_t>(n - 1));
    *report.answer = has_map ? MissingRobot(report.pose) : MissingMap(report.pose);
  }
  return absl::OkStatus();
}

// A robot or map that goes in the meantime, or a deadlock: then one report alone is at fault.
bool ConcernsOne(const absl::Status& status) {
  return !ConstraintOf(status).empty() || absl::IsAborted(status) || absl::IsInvalidArgument(status) ||
         absl::IsOutOfRange(status);
}

// Of different robots.
void ReportOfEach(Pool& pool, const CallContext& context, const std::vector<OpenReport>& reports) {
  const auto missing = StorePoses(pool, context, reports);
  const absl::Status status = missing.ok() ? AnswerReports(*missing, reports) : missing.status();
  if (status.ok()) return;
  if (reports.size() > 1 && ConcernsOne(status)) {
    for (const OpenReport& report : reports) ReportOfEach(pool, context, {report});
    return;
  }
  const std::string constraint = ConstraintOf(status);
  for (const OpenReport& report : reports) {
    if (constraint == "robot_poses_site_id_map_id_fkey") {
      *report.answer = MissingMap(report.pose);
    } else if (constraint == "robot_poses_site_id_robot_id_fkey") {
      *report.answer = MissingRobot(report.pose);
    } else {
      *report.answer = WithContext(status, NameOf(report.pose.site, report.pose.robot));
    }
  }
}

}  // namespace

std::vector<absl::Status> RobotPoseStore::ReportAll(const CallContext& context,
                                                    const std::vector<RobotPose>& poses) const {
  std::vector<absl::Status> answers(poses.size());
  std::vector<std::vector<OpenReport>> rounds;  // the n-th has the n-th report of each robot
  std::map<RobotId, std::size_t> reports_of;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    absl::StatusOr<RobotPose> pose = Receive(poses[i]);
    if (!pose.ok()) {
      answers[i] = pose.status();
      continue;
    }
    const std::size_t round = reports_of[pose->robot]++;
    if (round == rounds.size()) rounds.emplace_back();
    rounds[round].push_back({*std::move(pose), &answers[i]});
  }
  for (const std::vector<OpenReport>& round : rounds) ReportOfEach(pool_, context, round);
  return answers;
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
