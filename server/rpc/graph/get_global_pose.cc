// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/graph/get_global_pose.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/graph/messages.h"
#include "server/rpc/rearrange/resolve_map.h"

namespace enfilade::server {
namespace {

v1::GlobalPose Answer(const SiteId& site, const std::optional<graph::GlobalPose>& pose, std::int64_t graph_version) {
  v1::GlobalPose out;
  out.set_graph_version(graph_version);
  if (pose) Fill(site, *pose, out);
  return out;
}

struct GivenPose {
  convert::MapName name;
  PoseWithCovariance T_map_robot;
};

absl::StatusOr<GivenPose> Parse(const v1::MapPose& message) {
  ENFILADE_ASSIGN_OR_RETURN(convert::MapName name, convert::ParseMapName("map_pose.map", message.map()));
  ENFILADE_ASSIGN_OR_RETURN(PoseWithCovariance T_map_robot,
                            enfilade::convert::FromProto("map_pose.pose_map_robot", message.pose_map_robot()));
  return GivenPose{std::move(name), T_map_robot};
}

// What plans contribute, if that is wanted.
absl::Status Explain(const SiteGraph& graph, const v1::GetGlobalPoseRequest& request,
                     std::optional<graph::GlobalPose>& pose) {
  if (!request.with_prior_hops() || !pose) return absl::OkStatus();
  return graph::ExplainPlans(graph.graph(), *pose);
}

absl::StatusOr<v1::GetGlobalPoseResponse> AnswerGiven(const SiteGraph& graph, const GivenPose& given,
                                                      const v1::GetGlobalPoseRequest& request) {
  v1::GetGlobalPoseResponse response;
  ENFILADE_ASSIGN_OR_RETURN(auto pose, graph.poses.Find(given.name.map, given.T_map_robot));
  ENFILADE_RETURN_IF_ERROR(Explain(graph, request, pose));
  *response.mutable_global_pose() = Answer(given.name.site, pose, graph.graph().version());
  *response.mutable_global_pose()->mutable_map_pose() = request.map_pose();
  return response;
}

}  // namespace

v1::GlobalPose ToProto(const storage::RobotPose& report, const std::optional<graph::GlobalPose>& pose,
                       std::int64_t graph_version) {
  v1::GlobalPose out = Answer(report.site, pose, graph_version);
  out.set_robot(convert::NameOf(convert::RobotName{report.site, report.robot}));
  out.mutable_map_pose()->set_map(convert::NameOf(convert::MapName{report.site, report.map}));
  *out.mutable_map_pose()->mutable_pose_map_robot() = convert::ToProto(report.T_map_robot);
  *out.mutable_report_time() = convert::ToTimestamp(report.time);
  return out;
}

std::optional<absl::StatusOr<v1::GetGlobalPoseResponse>> TryGetGlobalPose(const Services& services,
                                                                          const v1::GetGlobalPoseRequest& request) {
  if (!request.has_map_pose() || request.with_prior_hops()) return std::nullopt;
  const absl::StatusOr<GivenPose> given = Parse(request.map_pose());
  if (!given.ok()) return given.status();
  const auto graph = services.graphs.FindCurrent(given->name.site);
  if (graph == nullptr || graph->graph().FindMap(given->name.map) == nullptr) return std::nullopt;
  return AnswerGiven(*graph, *given, request);
}

absl::StatusOr<v1::GetGlobalPoseResponse> GetGlobalPose(const Services& services, const Call& call,
                                                        const v1::GetGlobalPoseRequest& request) {
  switch (request.subject_case()) {
    case v1::GetGlobalPoseRequest::kMapPose: {
      ENFILADE_ASSIGN_OR_RETURN(GivenPose given, Parse(request.map_pose()));
      ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(call.context(), given.name.site));
      ENFILADE_ASSIGN_OR_RETURN(const auto resolved, ResolveMap(services, call, graph->graph(), given.name));
      given.name.map = resolved.to;
      given.T_map_robot = rearrange::Moved(resolved.T_to_from, given.T_map_robot);
      return AnswerGiven(*graph, given, request);
    }
    case v1::GetGlobalPoseRequest::kRobot: {
      v1::GetGlobalPoseResponse response;
      ENFILADE_ASSIGN_OR_RETURN(const convert::RobotName name, convert::ParseRobotName("robot", request.robot()));
      ENFILADE_ASSIGN_OR_RETURN(const storage::RobotPose report,
                                services.robot_poses.Get(call.context(), name.site, name.robot));
      ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(call.context(), name.site));
      ENFILADE_ASSIGN_OR_RETURN(auto pose, graph->poses.Find(report.map, report.T_map_robot));
      ENFILADE_RETURN_IF_ERROR(Explain(*graph, request, pose));
      *response.mutable_global_pose() = ToProto(report, pose, graph->graph().version());
      return response;
    }
    default:
      return InvalidArgument("subject is not set: expected a robot or a pose in a map");
  }
}

}  // namespace enfilade::server
