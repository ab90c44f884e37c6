// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "storage/call_context.h"

namespace enfilade::storage {

// A robot's pose in a map, as the robot or the mapping of its session reports it.
struct RobotPose {
  SiteId site;
  RobotId robot;
  MapId map;
  std::optional<SessionId> session;  // that it was reported in
  PoseWithCovariance T_map_robot;    // m, rad
  TimeNs time = 0;                   // by the robot's clock
  std::int64_t version = 0;          // set by the store: a new value with every report
  TimeNs received = 0;               // by the server's clock; set by the store
};

// A robot's clock may be this far ahead of the server's.
constexpr DurationNs kMaxPoseLead = 10 * kNsPerSecond;

// The pose, received now. INVALID_ARGUMENT if a number is not finite, the covariance is invalid, or the pose's time is
// more than kMaxPoseLead ahead of the server's clock.
absl::StatusOr<RobotPose> Receive(const RobotPose& pose);
// Whether `pose` is later than the stored one, or estimates the same moment of the same session again. A time ahead of
// the server's clock counts as the time of receipt, so that a clock that was ahead does not silence its robot.
bool Replaces(const RobotPose& pose, const RobotPose& stored);

// The last reported pose of each robot. Thread-safe; errors common to all stores: see SiteStore.
class RobotPoseStore {
 public:
  virtual ~RobotPoseStore() = default;

  // Keeps the latest pose of each robot: one that does not replace the stored one (Replaces) is ignored. All poses are
  // of one site, and taken one after the other, in few statements. An answer for each, in their order: NOT_FOUND naming
  // the robot or map that is missing; INVALID_ARGUMENT as from Receive. What is wrong with one does not harm others.
  virtual std::vector<absl::Status> ReportAll(const CallContext& context,
                                              const std::vector<RobotPose>& poses) const = 0;
  // The same for one.
  absl::Status Report(const CallContext& context, const RobotPose& pose) const;
  // NOT_FOUND if the robot has reported no pose.
  virtual absl::StatusOr<RobotPose> Get(const CallContext& context, const SiteId& site, const RobotId& robot) const = 0;
  // Of all robots of the site that have reported a pose, by robot.
  virtual absl::StatusOr<std::vector<RobotPose>> List(const CallContext& context, const SiteId& site) const = 0;
};

}  // namespace enfilade::storage
