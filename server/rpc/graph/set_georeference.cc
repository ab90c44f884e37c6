// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/graph/messages.h"

namespace enfilade::server {
namespace {

constexpr int kMaxControlPoints = 1000;

absl::StatusOr<std::vector<storage::ControlPoint>> Parse(const SiteId& site, const v1::Georeference& message) {
  if (message.control_points_size() > kMaxControlPoints) {
    return InvalidArgument("georeference.control_points has {} points: at most {}", message.control_points_size(),
                           kMaxControlPoints);
  }
  std::vector<storage::ControlPoint> points;
  for (int i = 0; i < message.control_points_size(); ++i) {
    const v1::ControlPoint& point = message.control_points(i);
    ENFILADE_ASSIGN_OR_RETURN(
        const convert::MapName map,
        convert::ParseMapName(fmt::format("georeference.control_points[{}].map", i), point.map()));
    if (map.site != site) return InvalidArgument("georeference.control_points[{}].map is of another site", i);
    points.push_back({.map = map.map,
                      .position = {point.x(), point.y()},
                      .latitude = point.latitude(),
                      .longitude = point.longitude()});
  }
  return points;
}

}  // namespace

absl::StatusOr<v1::SetGeoreferenceResponse> SetGeoreference(const Services& services, const Call& call,
                                                            const v1::SetGeoreferenceRequest& request) {
  v1::SetGeoreferenceResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("site", request.site()));
  ENFILADE_ASSIGN_OR_RETURN(const auto points, Parse(site, request.georeference()));
  // Fitted before it is stored, to refuse points that do not fit.
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(call.context(), site));
  if (!points.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const geo::GeoreferenceFit fit, FitControlPoints(graph->poses, points));
    *response.mutable_georeference() = ToProto(site, *graph, fit, points);
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            services.graph_editor.SetControlPoints(call.context(), site, points));
  response.mutable_georeference()->set_graph_version(version);
  return response;
}

}  // namespace enfilade::server
