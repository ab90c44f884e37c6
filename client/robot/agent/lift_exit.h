// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/doors/door_event.h"
#include "core/geometry/pose2.h"

namespace enfilade::robot {

// The way out of a lift that the detector missed. A session that went on there would hold what the robot has seen on
// two levels. A robot that has come to another level leaves the cabin by the door that it entered it by or, where that
// is not known, has left it once it is as far away as no cabin is deep.
class LiftExit {
 public:
  // The robot has come to another level.
  void Begin(const Pose2& T_odom_robot);
  // By this passage, if it is not too far away.
  void EnteredBy(const doors::DoorEvent& passage);

  // Whether the robot is still in the cabin, as far as is known.
  bool is_awaited() const { return start_.has_value(); }

  // Nothing to look for any more: the detector has found the door.
  void Stop() { start_.reset(); }

  // Where the robot is, in the order of time.
  void Add(TimeNs time, const Pose2& T_odom_robot);

  // The passage out of the cabin, as soon as it is certain that the detector has missed it.
  std::optional<doors::DoorEvent> FindMissed() const;

  // The passage out of the cabin, if the robot went through another door after it, at `T_odom_door`.
  std::optional<doors::DoorEvent> FindBefore(const Pose2& T_odom_door) const;

 private:
  struct Place {
    TimeNs time = 0;
    Pose2 T_odom_robot;
  };

  // Out by the door that it came in by.
  std::optional<doors::DoorEvent> FindThroughEntry() const;
  doors::DoorEvent EventAt(const Place& place, const Pose2& T_odom_door, double width) const;

  std::optional<Pose2> start_;  // T_odom_robot at the end of the ride; unset: nothing to look for
  std::optional<doors::DoorEvent> entry_;
  std::vector<Place> way_;  // since then
};

}  // namespace enfilade::robot
