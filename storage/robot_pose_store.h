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
namespace postgres {
class Pool;
}

// Where a robot says it is.
struct RobotPose {
  SiteId site;
  RobotId robot;
  MapId map;
  std::optional<SessionId> session;  // that it was reported in
  PoseWithCovariance T_map_robot;    // m, rad
  TimeNs time = 0;                   // by the robot's clock
  std::int64_t version = 0;          // set by the store: another one with every report
};

// The last reported pose of each robot. Thread-safe; errors common to all stores: see SiteStore.
class RobotPoseStore {
 public:
  explicit RobotPoseStore(postgres::Pool& pool) : pool_(pool) {}

  // The newest by its time wins: an older one than the stored changes nothing. One of the same time replaces it only
  // where both are of the same session, which has then estimated that moment anew. NOT_FOUND naming the robot or map
  // that is missing; INVALID_ARGUMENT where a number is not finite.
  absl::Status Report(const CallContext& context, const RobotPose& pose) const;
  // NOT_FOUND where the robot has reported none.
  absl::StatusOr<RobotPose> Get(const CallContext& context, const SiteId& site, const RobotId& robot) const;
  // Of all robots of the site that have reported one, by robot.
  absl::StatusOr<std::vector<RobotPose>> List(const CallContext& context, const SiteId& site) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
