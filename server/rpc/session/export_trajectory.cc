// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/session/export_trajectory.h"

#include <algorithm>
#include <memory>

#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kPosesPerMessage = 4096;

}  // namespace

absl::StatusOr<MessageSource<v1::ExportTrajectoryResponse>> ExportTrajectory(
    const Services& services, const Call& call, const v1::ExportTrajectoryRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::SessionName name, convert::ParseSessionName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(storage::Trajectory read,
                            services.mappings.ReadTrajectory(call.context(), name.site, name.session));
  auto trajectory = std::make_shared<const storage::Trajectory>(std::move(read));
  return [trajectory, next = std::size_t{0}](v1::ExportTrajectoryResponse& message) mutable -> absl::StatusOr<bool> {
    if (next > 0 && next >= trajectory->poses.size()) return false;
    message.Clear();
    message.set_mapped_sequence(trajectory->mapped_sequence);
    const std::size_t end = std::min(next + kPosesPerMessage, trajectory->poses.size());
    for (; next < end; ++next) {
      v1::TrajectoryPose& pose = *message.add_poses();
      *pose.mutable_time() = convert::ToTimestamp(trajectory->poses[next].time);
      *pose.mutable_pose_map_robot() = convert::ToProto(trajectory->poses[next].T_map_robot);
    }
    next = std::max<std::size_t>(next, 1);  // an empty trajectory is one empty message
    return true;
  };
}

}  // namespace enfilade::server
