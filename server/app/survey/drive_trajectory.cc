// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_trajectory.h"

#include <algorithm>
#include <iterator>

namespace enfilade::server {
namespace {

bool IsBefore(const slam::StampedPose& pose, TimeNs time) { return pose.time < time; }

}  // namespace

ReportedDoor ToReportedDoor(const sensor::DoorReport& report, const std::optional<Pose2>& T_odom_robot) {
  ReportedDoor door{.passed = report.door_time, .reported = report.time, .T_robot_door = {}, .width = report.width};
  if (T_odom_robot) door.T_robot_door = Between(*T_odom_robot, report.T_odom_door);
  return door;
}

Pose2 PoseAt(const DriveTrajectory& trajectory, TimeNs time) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), time, IsBefore);
  if (after == trajectory.begin()) return after->T_map_robot;
  if (after == trajectory.end()) return trajectory.back().T_map_robot;
  const auto before = std::prev(after);
  return Interpolate(before->T_map_robot, after->T_map_robot,
                     ToSeconds(time - before->time) / ToSeconds(after->time - before->time));
}

std::optional<rooms::PassageHint> PassageAt(const DriveTrajectory& trajectory, const ReportedDoor& door) {
  constexpr TimeNs kScans = 500'000'000;  // the report may be later than the last scan
  if (door.passed > trajectory.back().time + kScans) return std::nullopt;
  const bool seen = door.T_robot_door && door.reported <= trajectory.back().time + kScans;
  const Pose2 T_level_door =
      seen ? PoseAt(trajectory, door.reported) * *door.T_robot_door : PoseAt(trajectory, door.passed);
  return rooms::PassageThrough(T_level_door, door.width);
}

void PlaceVisits(const DriveTrajectory& trajectory, survey::Drive& drive) {
  if (trajectory.empty()) return;
  const survey::Visit* before = nullptr;
  for (survey::SurveyedSession& session : drive) {
    std::erase_if(session.visits, [&](survey::Visit& visit) {
      const auto found = std::lower_bound(trajectory.begin(), trajectory.end(), visit.time, IsBefore);
      if (found == trajectory.end() || found->time != visit.time) return true;
      visit.T_level_robot = found->T_map_robot;
      return false;
    });
    if (session.visits.empty() && before != nullptr && session.T_map_entry) {
      session.visits.push_back({0, before->time, *session.T_map_entry, before->T_level_robot});
    }
    if (!session.visits.empty()) before = &session.visits.back();
  }
}

}  // namespace enfilade::server
