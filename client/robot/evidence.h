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

// The last images and clouds, thinned along the way driven, and the choice of those that say where a door leads from
// and to. Depth images are none of its business. Not thread-safe.
class EvidenceBuffer {
 public:
  explicit EvidenceBuffer(const EvidenceOptions& options) : options_(options) {}

  // An image or a cloud, taken while odometry said `T_odom_robot`.
  void Add(const client::SpoolItem& item, const Pose2& T_odom_robot);

  // What was seen at `time`: the nearest front image, rear image and cloud, as far as there are any within max_age.
  std::vector<client::SpoolItem> At(TimeNs time) const;

  // What was seen of the map entered: of each camera up to `images` images between the door and the report, spread over
  // the way, and the cloud farthest behind the door. Of a report by hand: what was seen in the last max_age.
  std::vector<client::SpoolItem> Behind(const sensor::DoorReport& report) const;

  std::size_t size() const;

 private:
  struct Seen {
    client::SpoolItem item;
    Pose2 T_odom_robot;
  };
  enum class Kind { kFront, kRear, kCloud };
  static std::optional<Kind> KindOf(const client::SpoolItem& item);

  EvidenceOptions options_;
  // In the order of time; the last one is the newest, whether or not the robot has moved since the one before.
  std::map<Kind, std::deque<Seen>> seen_;
};

// In the order of time, each once.
std::vector<client::SpoolItem> Joined(std::vector<client::SpoolItem> a, const std::vector<client::SpoolItem>& b);

}  // namespace enfilade::robot
