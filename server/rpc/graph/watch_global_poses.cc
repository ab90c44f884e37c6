// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/graph/watch_global_poses.h"

#include <memory>
#include <utility>

#include "core/base/status_macros.h"
#include "server/rpc/graph/pose_watch.h"

namespace enfilade::server {

absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>> WatchGlobalPoses(const Services& services, const Call& /*call*/,
                                                                     const v1::WatchGlobalPosesRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(PoseWatch created, PoseWatch::Create(request));
  const auto watch = std::make_shared<PoseWatch>(std::move(created));
  return Watch<v1::WatchGlobalPosesResponse>{
      .period = watch->period(),
      .check = [&services, watch](
                   const storage::CallContext& context,
                   v1::WatchGlobalPosesResponse& message) { return watch->Check(services, context, message); },
      .stopping = [&services] { return services.graphs.stopping(); }};
}

}  // namespace enfilade::server
