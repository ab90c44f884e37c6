// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/binary.h"
#include "core/doors/door_event.h"
#include "core/doors/door_options.h"
#include "core/doors/door_track.h"
#include "core/doors/driven_path.h"
#include "core/doors/local_map.h"
#include "core/doors/narrows.h"
#include "core/doors/passage_evidence.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::doors {

// Finds doors as narrow places that the robot's path crosses (docs/doors.md):
//  ahead: several scans see the same narrow place ahead before the robot reaches it;
//  behind: a little behind it the local map still shows it, across the path that was driven;
//  environment: what was in sight before the door is hidden behind it, or vice versa.
// Behind and one of the others make a passage if the narrow place is a gap in a wall (passage_evidence.h).
class GapDetector {
 public:
  explicit GapDetector(const DoorOptions& options);

  void Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot, std::vector<DoorEvent>& events);
  void Finish(std::vector<DoorEvent>& events);
  void Write(BinaryWriter& writer) const;
  bool Read(BinaryReader& reader);

 private:
  // A narrow place that the path has crossed.
  struct Crossing {
    Narrows door;
    double at = 0.0;     // travelled, m
    std::string reason;  // why it is a narrow place
  };

  void SearchAhead(std::vector<DoorEvent>& events);
  bool IsNewDoor(const Narrows& door) const;
  void UpdateCrossings();
  void SearchBehind(std::vector<DoorEvent>& events);
  std::optional<Eigen::Vector2d> PathDirectionAt(double travelled) const;
  // The same place as it was seen ahead; null: it was not.
  DoorTrack* FindTrack(const Narrows& door);
  void JudgeCrossing(const Crossing& crossing, std::vector<DoorEvent>& events);
  PassageEvidence GatherEvidence(const Crossing& crossing, const DoorTrack* track) const;
  CriterionVerdict JudgeEnvironment(const Crossing& crossing, double* hidden) const;
  void ReportCandidates(bool all, std::vector<DoorEvent>& events);
  void ForgetDistantTracks();
  DoorEvent EventOf(DoorEvent::Kind kind) const;
  DoorEvent CandidateOf(const DoorTrack& track, DoorEvent::Kind kind) const;

  DoorOptions options_;
  LocalMap map_;
  DrivenPath path_;
  std::vector<DoorTrack> tracks_;
  std::int64_t doors_ = 0;
  double searched_ = 0.0;       // travelled, m, up to which the path behind was searched
  double last_passage_ = -1e9;  // travelled, m
};

}  // namespace enfilade::doors
