// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/base/binary.h"
#include "core/doors/door_event.h"
#include "core/doors/door_options.h"
#include "core/doors/jamb_derivative.h"
#include "core/sensor/laser_scan.h"
#include "core/sensor/scan_box.h"

namespace enfilade::doors {

// The sequence of map_manager: the door ahead (three hits in three seconds) latches a candidate; the door behind (three
// hits, after 1.5 to 5 m, with the same heading) or a changed environment make it a passage; at the time limit a
// latched door that was not driven through becomes a candidate. Times are the scans'.
class DerivativeDetector {
 public:
  explicit DerivativeDetector(const DoorOptions& options) : options_(options) {}

  void Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot, std::vector<DoorEvent>& events);
  void Finish(std::vector<DoorEvent>& events);
  void Write(BinaryWriter& writer) const;
  bool Read(BinaryReader& reader);

 private:
  struct Latch {
    std::int64_t door = 0;
    TimeNs time = 0;
    Pose2 T_odom_robot;
  };

  void SearchAhead(const sensor::LaserScan& scan, const Pose2& T_odom_robot, std::vector<DoorEvent>& events);
  void SearchBehind(const sensor::LaserScan& scan, const Pose2& T_odom_robot);
  void CompareBoxes(const sensor::LaserScan& scan, const Pose2& T_odom_robot);
  void Conclude(TimeNs time, const Pose2& T_odom_robot, std::vector<DoorEvent>& events);
  DoorEvent EventOf(DoorEvent::Kind kind, TimeNs time, const Pose2& T_odom_robot) const;
  void ReportCandidate(TimeNs time, const Pose2& T_odom_robot, std::vector<DoorEvent>& events) const;
  int CountMet() const;
  void Reset();

  DoorOptions options_;
  std::int64_t doors_ = 0;
  std::optional<Pose2> last_latched_;

  // The state of one attempt, from its first hit on.
  std::optional<TimeNs> begin_;
  int ahead_hits_ = 0;
  TimeNs first_ahead_ = 0;
  TimeNs last_ahead_ = 0;
  int behind_hits_ = 0;
  TimeNs last_behind_ = 0;
  std::optional<Latch> latch_;
  CriterionVerdict ahead_;
  CriterionVerdict behind_;
  CriterionVerdict environment_;
  Pose2 last_pose_;
  TimeNs last_time_ = 0;

  std::optional<Eigen::AlignedBox2d> box_;
  TimeNs box_time_ = 0;
};

}  // namespace enfilade::doors
