// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/drive_reader.h"

#include <algorithm>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

const storage::StoredDoorReport* LastPassage(const std::vector<storage::StoredDoorReport>& reports) {
  const auto last = std::find_if(reports.rbegin(), reports.rend(), [](const storage::StoredDoorReport& stored) {
    return stored.report.kind == sensor::DoorReport::Kind::kPassage;
  });
  return last == reports.rend() ? nullptr : &*last;
}

bool IsByHand(const storage::StoredDoorReport& stored) { return stored.report.by_hand; }

}  // namespace

absl::StatusOr<bool> DriveReader::IsDrivenByDoors(const StoredDrive& drive) const {
  const auto has_reports = [](const storage::Session* session) { return session->record_counts.door_reports > 0; };
  if (std::any_of(drive.begin(), drive.end(), has_reports)) return true;
  const std::optional<SessionId>& previous = drive.front()->entry.previous;
  if (!previous) return false;
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<sensor::DoorReport> passage, FindPassage(*previous));
  return passage && !passage->by_hand;
}

absl::StatusOr<ReadDrive> DriveReader::Read(const StoredDrive& stored) const {
  ReadDrive drive;
  for (const storage::Session* session : stored) {
    survey::SurveyedSession one{.id = session->id, .map = *session->map};
    if (session->entry.T_map_robot) one.T_map_entry = session->entry.T_map_robot->pose;
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<slam::SlamNode> nodes,
                              stores_.mappings.ListKeyframes(SurveyContext(), site_, session->id));
    for (const slam::SlamNode& node : nodes) one.visits.push_back({node.sequence, node.time, node.T_map_node, {}});
    ENFILADE_ASSIGN_OR_RETURN(const std::vector<storage::StoredDoorReport> reports, ReadReports(session->id));
    if (std::any_of(reports.begin(), reports.end(), IsByHand)) return ReadDrive{};
    if (const storage::StoredDoorReport* passage = LastPassage(reports)) {
      one.left = passage->report.door_time;
      drive.doors.push_back(ToReportedDoor(passage->report, passage->T_odom_robot));
    }
    drive.sessions.push_back(std::move(one));
  }
  return drive;
}

absl::StatusOr<survey::Ride> DriveReader::ReadRide(const SessionId& session) const {
  survey::Ride ride{.session = session};
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<slam::SlamNode> nodes,
                            stores_.mappings.ListKeyframes(SurveyContext(), site_, session));
  for (const slam::SlamNode& node : nodes) ride.T_map_robot.push_back(node.T_map_node);
  return ride;
}

absl::StatusOr<std::optional<TimeNs>> DriveReader::FindEndOnLevel(const survey::SurveyedSession& session) const {
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<sensor::DoorReport> passage, FindPassage(session.id));
  return passage && passage->level_time ? passage->level_time : session.left;
}

absl::StatusOr<std::optional<MapId>> DriveReader::FindMap(const SessionId& session) const {
  const absl::StatusOr<storage::Session> found = stores_.sessions.Get(SurveyContext(), site_, session);
  if (absl::IsNotFound(found.status())) return std::nullopt;
  ENFILADE_RETURN_IF_ERROR(found.status());
  return found->map;
}

absl::StatusOr<std::optional<Pose2>> DriveReader::FindPose(const SessionId& session, TimeNs time) const {
  ENFILADE_ASSIGN_OR_RETURN(const storage::Trajectory trajectory,
                            stores_.mappings.ReadTrajectory(SurveyContext(), site_, session));
  const auto last = std::find_if(trajectory.poses.rbegin(), trajectory.poses.rend(),
                                 [time](const slam::StampedPose& pose) { return pose.time <= time; });
  return last == trajectory.poses.rend() ? std::nullopt : std::optional(last->T_map_robot);
}

absl::StatusOr<std::optional<Pose2>> DriveReader::FindFirstPose(const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(const storage::Trajectory trajectory,
                            stores_.mappings.ReadTrajectory(SurveyContext(), site_, session));
  return trajectory.poses.empty() ? std::nullopt : std::optional(trajectory.poses.front().T_map_robot);
}

absl::StatusOr<std::optional<sensor::DoorReport>> DriveReader::FindPassage(const SessionId& session) const {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<storage::StoredDoorReport> reports, ReadReports(session));
  const storage::StoredDoorReport* passage = LastPassage(reports);
  return passage == nullptr ? std::nullopt : std::optional(passage->report);
}

absl::StatusOr<std::optional<closure::DoorVerdict>> DriveReader::FindVerdict(const SessionId& session) const {
  return stores_.verdicts.FindPassage(SurveyContext(), site_, session);
}

absl::StatusOr<std::map<LinkPointId, survey::SeenGap>> DriveReader::FindGaps() const {
  ENFILADE_ASSIGN_OR_RETURN(const auto candidates, stores_.verdicts.ListCandidateReports(SurveyContext(), site_));
  std::map<LinkPointId, survey::SeenGap> gaps;
  for (const auto& [candidate, report] : candidates) {
    if (!report.T_odom_gap) continue;
    gaps[candidate] = {Between(report.T_odom_door, *report.T_odom_gap), report.width};
  }
  return gaps;
}

absl::StatusOr<std::vector<storage::StoredDoorReport>> DriveReader::ReadReports(const SessionId& session) const {
  return stores_.verdicts.ReadReports(SurveyContext(), site_, session);
}

}  // namespace enfilade::server
