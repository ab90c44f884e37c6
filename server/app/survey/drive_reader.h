// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/closure/door_verdict.h"
#include "core/sensor/record.h"
#include "core/survey/level_survey.h"
#include "server/app/survey/drive_trajectory.h"
#include "server/app/survey/session_reader.h"
#include "server/app/survey/stored_drives.h"
#include "storage/graph/door_verdict_store.h"
#include "storage/graph/plan_join_store.h"
#include "storage/maps/map_store.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/record_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

struct SurveyStores {
  const storage::SessionStore& sessions;
  const storage::RecordStore& records;
  const storage::MappingStore& mappings;
  const storage::MapReader& maps;
  const storage::DoorVerdictStore& verdicts;
  const storage::PlanJoinStore& plan_joins;
};

struct ReadDrive {
  survey::Drive sessions;           // visits have no pose on the level yet
  std::vector<ReportedDoor> doors;  // at the sessions' ends
};

// What is stored of a site's drives. The stores and `proceed` must outlive it.
class DriveReader {
 public:
  // `proceed`: see SessionReader.
  DriveReader(const SurveyStores& stores, const SiteId& site, const std::function<absl::Status()>& proceed)
      : stores_(stores), site_(site), sessions_(stores.records, stores.mappings, site_, proceed) {}

  // Whether the robot's detector reported doors in the drive, or the one that the robot came through. Maps that people
  // record as one, or divide by hand, stay as they are.
  absl::StatusOr<bool> IsDrivenByDoors(const StoredDrive& drive) const;

  // Empty if a person divided the drive by commands.
  absl::StatusOr<ReadDrive> Read(const StoredDrive& stored) const;

  absl::StatusOr<survey::Ride> ReadRide(const SessionId& session) const;

  // Unset: the session has been deleted, or has no map.
  absl::StatusOr<std::optional<MapId>> FindMap(const SessionId& session) const;

  // When the robot was no longer on the level of a session whose door leads to another one: when it came to that one in
  // the cabin of a lift, if it said so, or at the door.
  absl::StatusOr<std::optional<TimeNs>> FindEndOnLevel(const survey::SurveyedSession& session) const;

  // Where the robot was in the session's map when it left it: at the last scan up to `time`. Unset without any.
  absl::StatusOr<std::optional<Pose2>> FindPose(const SessionId& session, TimeNs time) const;

  // Where the robot was in the session's map at its first scan. Unset without any.
  absl::StatusOr<std::optional<Pose2>> FindFirstPose(const SessionId& session) const;

  // The door at the session's end, as the robot reported it. Unset if there is none.
  absl::StatusOr<std::optional<sensor::DoorReport>> FindPassage(const SessionId& session) const;

  // What the server made of that report. Unset as long as it is not judged.
  absl::StatusOr<std::optional<closure::DoorVerdict>> FindVerdict(const SessionId& session) const;

  // survey::LevelSurvey::gaps of the site's candidates.
  absl::StatusOr<std::map<LinkPointId, survey::SeenGap>> FindGaps() const;

  const SessionReader& sessions() const { return sessions_; }

 private:
  absl::StatusOr<std::vector<storage::StoredDoorReport>> ReadReports(const SessionId& session) const;

  const SurveyStores& stores_;
  const SiteId& site_;
  const SessionReader sessions_;
};

}  // namespace enfilade::server
