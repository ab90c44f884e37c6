// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/graph/messages.h"
#include "server/rpc/rearrange/resolve_map.h"

namespace enfilade::server {
namespace {

constexpr int kMaxPoses = 10'000;

}  // namespace

absl::StatusOr<v1::TransformPosesResponse> TransformPoses(const Services& services, const Call& call,
                                                          const v1::TransformPosesRequest& request) {
  v1::TransformPosesResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName source, convert::ParseMapName("source_map", request.source_map()));
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName target, convert::ParseMapName("target_map", request.target_map()));
  if (source.site != target.site) return InvalidArgument("source_map and target_map are of different sites");
  if (request.poses_size() > kMaxPoses) {
    return InvalidArgument("poses has {} poses: at most {}", request.poses_size(), kMaxPoses);
  }
  std::vector<PoseWithCovariance> poses;
  for (int i = 0; i < request.poses_size(); ++i) {
    ENFILADE_ASSIGN_OR_RETURN(const PoseWithCovariance pose,
                              enfilade::convert::FromProto(fmt::format("poses[{}]", i), request.poses(i)));
    poses.push_back(pose);
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(call.context(), source.site));
  response.set_graph_version(graph->graph().version());
  ENFILADE_ASSIGN_OR_RETURN(const auto from, ResolveMap(services, call, graph->graph(), source));
  ENFILADE_ASSIGN_OR_RETURN(const auto to, ResolveMap(services, call, graph->graph(), target));
  ENFILADE_ASSIGN_OR_RETURN(std::optional<graph::MapTransform> T_target_source,
                            graph::FindTransform(graph->graph(), to.to, from.to));
  if (!T_target_source.has_value()) return response;
  if (from.to != source.map || to.to != target.map) {
    const PoseWithCovariance T_from_source{from.T_to_from, Eigen::Matrix3d::Zero()};
    T_target_source->T_a_b = rearrange::Moved(Inverse(to.T_to_from), Compose(T_target_source->T_a_b, T_from_source));
  }
  *response.mutable_pose_target_source() = convert::ToProto(T_target_source->T_a_b);
  for (const graph::PoseHop& hop : T_target_source->hops) *response.add_hops() = ToProto(source.site, hop);
  response.set_solution_version(T_target_source->solution_version.value_or(0));
  for (const PoseWithCovariance& pose : enfilade::graph::TransformPoses(*T_target_source, poses)) {
    *response.add_poses() = convert::ToProto(pose);
  }
  return response;
}

}  // namespace enfilade::server
