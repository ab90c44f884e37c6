// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <vector>

#include "core/base/binary.h"
#include "core/doors/door_event.h"
#include "core/doors/door_options.h"
#include "core/doors/local_map.h"
#include "core/doors/narrows.h"
#include "core/doors/visibility.h"
#include "core/sensor/laser_scan.h"

namespace enfilade::doors {

// Doors as narrow places that the robot's way crosses (docs/doors.md):
//  ahead: scans see the same narrow place ahead, several times, before it is reached;
//  behind: a little behind it the local map still holds it, across the way that was driven;
//  environment: what was in sight before it is hidden behind it, or the other way round.
// Behind and one of the others make a passage where the narrow place is a gap in a wall (passage_evidence.h).
class GapDetector {
 public:
  explicit GapDetector(const DoorOptions& options);

  void Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot, std::vector<DoorEvent>& events);
  void Finish(std::vector<DoorEvent>& events);
  void Write(BinaryWriter& writer) const;
  bool Read(BinaryReader& reader);

 private:
  // A narrow place seen ahead.
  struct Track {
    Narrows narrows;
    int hits = 0;
    TimeNs last_hit = 0;
    std::int64_t door = 0;  // its number once latched
    bool told = false;      // as a candidate
    TimeNs latch_time = 0;
    Pose2 T_odom_latch;
    double crossed_at = -1.0;  // travelled, m, where the way crossed it; -1: not yet
  };
  struct PathPoint {
    double travelled = 0.0;  // m
    RangeView view;
  };

  void LookAhead(std::vector<DoorEvent>& events);
  void NoteCrossings();
  void LookBehind(std::vector<DoorEvent>& events);
  // `track`: the same place as it was seen ahead, or nullptr.
  void Decide(const Narrows& door, Track* track, double crossing, std::string behind_reason,
              std::vector<DoorEvent>& events);
  CriterionVerdict JudgeEnvironment(const Narrows& door, double crossing, double* hidden) const;
  void TellCandidates(bool all, std::vector<DoorEvent>& events);
  void Forget();
  DoorEvent CandidateOf(const Track& track, DoorEvent::Kind kind) const;

  std::size_t PathIndexAt(double travelled) const;
  Eigen::Vector2d PathAt(double travelled) const;

  DoorOptions options_;
  LocalMap map_;
  std::deque<PathPoint> path_;  // of the last metres
  std::vector<Track> tracks_;
  std::int64_t doors_ = 0;
  double judged_ = 0.0;         // travelled, m, up to which the way was looked back on
  double last_passage_ = -1e9;  // travelled, m
};

}  // namespace enfilade::doors
