// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/robot/robot_options.h"
#include "client/sdk/spool/spool.h"
#include "core/geometry/pose2.h"
#include "core/sensor/record.h"

namespace enfilade::robot {

// The latest images and clouds, thinned by the distance driven, from which the evidence for door reports is chosen:
// what the robot saw at a door and behind it. Depth images are ignored. Not thread-safe.
class EvidenceBuffer {
 public:
  explicit EvidenceBuffer(const EvidenceOptions& options) : options_(options) {}

  // An image or a cloud, taken at the odometry pose `T_odom_robot`.
  void Add(const client::SpoolItem& item, const Pose2& T_odom_robot);

  // The front image, the rear image and the cloud nearest to `time`, each only if it is within max_age.
  std::vector<client::SpoolItem> NearestTo(TimeNs time) const;

  // What was seen of the map entered: from each camera up to `images` images taken between the door and the report,
  // evenly spread, and the cloud taken farthest from the door. For a report by hand: from the last max_age.
  std::vector<client::SpoolItem> BehindDoor(const sensor::DoorReport& report) const;

  std::size_t size() const;

 private:
  struct Entry {
    client::SpoolItem item;
    Pose2 T_odom_robot;
  };
  enum class Kind { kFront, kRear, kCloud };
  static std::optional<Kind> KindOf(const client::SpoolItem& item);

  EvidenceOptions options_;
  // In order of time. The last one is the newest, even if the robot has not moved since the one before.
  std::map<Kind, std::deque<Entry>> entries_;
};

// Both lists in order of time, without duplicates.
std::vector<client::SpoolItem> MergedByTime(std::vector<client::SpoolItem> a, const std::vector<client::SpoolItem>& b);

}  // namespace enfilade::robot
