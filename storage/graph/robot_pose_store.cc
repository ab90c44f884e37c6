// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/robot_pose_store.h"

#include <algorithm>
#include <chrono>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/covariance.h"

namespace enfilade::storage {

absl::StatusOr<RobotPose> Receive(const RobotPose& pose) {
  if (!IsFinite(pose.T_map_robot.pose)) return InvalidArgument("the pose is not finite");
  ENFILADE_RETURN_IF_ERROR(ValidateMeasuredCovariance(pose.T_map_robot.covariance));
  RobotPose received = pose;
  received.received =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  if (pose.time > received.received + kMaxPoseLead) {
    return InvalidArgument("the pose's time is {:.0f} s ahead of the server's clock: expected at most {:.0f} s",
                           ToSeconds(pose.time - received.received), ToSeconds(kMaxPoseLead));
  }
  return received;
}

bool Replaces(const RobotPose& pose, const RobotPose& stored) {
  if (std::min(stored.time, stored.received) < std::min(pose.time, pose.received)) return true;
  return stored.time == pose.time && stored.session == pose.session;
}

absl::Status RobotPoseStore::Report(const CallContext& context, const RobotPose& pose) const {
  return ReportAll(context, {pose}).front();
}

}  // namespace enfilade::storage
