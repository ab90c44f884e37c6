// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::closure {

// The outcome of a door report. The numbers are in the database and on the wire: never reuse one.
enum class DoorDecision : std::int16_t {
  kCandidateMade = 1,
  kCandidateKnown = 2,
  kCandidatePromoted = 3,
  kLinkPointRecognised = 4,
  kLinkPointMade = 5,
  kNotJudged = 6,
};

// The comparison of one known place with what the robot saw.
struct DoorComparison {
  LinkPointId link_point;
  MapId map;                         // that the robot would have entered
  std::optional<double> distance;    // m between the place and the door, by the graph
  std::optional<int> image_matches;  // median over the robot's images; unset: no images
  bool images_agree = false;
  std::optional<double> rmse;  // m, of the registration; unset: not registered
  double inlier_share = 0.0;   // 0 to 1
  bool clouds_agree = false;
  std::optional<double> chi2;  // 3 degrees of freedom; unset: no prediction of the pose
  bool accepted = false;
  std::string reason;
};

struct DoorVerdict {
  SessionId session;
  std::int64_t sequence = 0;  // of the report's record
  DoorDecision decision = DoorDecision::kNotJudged;
  std::optional<LinkPointId> link_point;
  // Of a passage: the map that was entered, and the robot's pose in it when odometry had it at T_odom_robot.
  std::optional<MapId> entered_map;
  std::optional<PoseWithCovariance> T_map_robot;
  std::optional<Pose2> T_odom_robot;
  std::vector<DoorComparison> comparisons;  // the best first
  std::vector<std::int64_t> evidence;       // sequences of the session's records that were used
  std::string reason;
  std::int64_t graph_version = 0;  // that the report was judged by
  TimeNs create_time = 0;          // set by the store
};

}  // namespace enfilade::closure
