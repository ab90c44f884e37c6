// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "proto/convert/record.h"
#include "server/app/priors/plan_doors.h"
#include "server/app/priors/plans_beside.h"
#include "server/rpc/paging.h"
#include "server/rpc/prior/handlers.h"
#include "server/rpc/prior/product_file.h"

namespace enfilade::server {
namespace {

constexpr double kLeastReach = 1.0;    // m
constexpr double kReachSigmas = 2.45;  // holds 95 % in the plane

struct PlacedLinkPoint {
  LinkPointId id;
  Eigen::Vector2d position;
};

std::vector<PlacedLinkPoint> LinkPointsOn(const SiteGraph& graph, int level) {
  std::vector<PlacedLinkPoint> placed;
  for (const graph::LinkPoint* link_point : graph.lists().link_points) {
    const bool is_on_level =
        std::any_of(link_point->anchors.begin(), link_point->anchors.end(), [&](const graph::Anchor& anchor) {
          const graph::MapInGraph* map = graph.graph().FindMap(anchor.map);
          return map != nullptr && map->level == level;
        });
    if (!is_on_level || link_point->is_candidate()) continue;
    const auto place = graph::FindInWorld(graph.poses, *link_point);
    if (place) placed.push_back({link_point->id, place->pose.translation()});
  }
  return placed;
}

v1::PredictedLinkPoint DoorToProto(const closure::PlanDoor& door, int number, bool seen) {
  v1::PredictedLinkPoint out;
  out.set_door(number);
  *out.mutable_pose_world_place() = convert::ToProto(door.T_plan_door);
  out.set_width_m(door.width);
  out.set_sigma_m(door.sigma);
  out.set_seen(seen);
  return out;
}

// The nearest to the door, within its reach.
void AddLinkPoint(const std::vector<PlacedLinkPoint>& known, const SiteId& site, v1::PredictedLinkPoint& door) {
  const v1::Pose2& place = door.pose_world_place();
  double least = std::max(kLeastReach, kReachSigmas * door.sigma_m());
  for (const PlacedLinkPoint& one : known) {
    const double distance = (one.position - Eigen::Vector2d(place.x(), place.y())).norm();
    if (distance > least) continue;
    least = distance;
    door.set_link_point(NameOf(site, one.id));
  }
}

void AddSightings(const closure::SightedDoor& sighted, const SiteId& site, const std::vector<storage::PlanJoin>& joins,
                  v1::PredictedLinkPoint& door) {
  for (const LinkPointId& candidate : sighted.candidates) door.add_candidates(NameOf(site, candidate));
  door.set_reason(sighted.reason);
  for (const storage::PlanJoin& join : joins) {
    if (join.undone || door.link_point() != NameOf(site, join.link_point)) continue;
    door.set_joined_by_plan(true);
    door.set_reason(join.reason);
  }
}

}  // namespace

absl::StatusOr<v1::ListPredictedLinkPointsResponse> ListPredictedLinkPoints(
    const Services& services, const Call& call, const v1::ListPredictedLinkPointsRequest& request) {
  v1::ListPredictedLinkPointsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParsePriorMapName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t first, FromNumericPageToken(request.page_token(), 0));
  ENFILADE_ASSIGN_OR_RETURN(
      const std::string walls,
      ReadProductFile(services, call, name, storage::PriorMapProduct::kCorrected, kCorrectedWalls));
  ENFILADE_ASSIGN_OR_RETURN(const storage::PriorMap prior_map,
                            services.prior_maps.Get(call.context(), name.site, name.prior_map));
  ENFILADE_ASSIGN_OR_RETURN(CorrectedDoors doors, ParseCorrectedDoors(walls));
  ENFILADE_ASSIGN_OR_RETURN(const auto ties,
                            ReadTies(call.context(), services.prior_maps, services.blobs, name.site, name.prior_map));
  if (ties) doors.plan.maps = ties->maps;
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(call.context(), name.site));
  ENFILADE_ASSIGN_OR_RETURN(const auto joins, services.plan_joins.List(call.context(), name.site));
  const std::vector<PlacedLinkPoint> known = LinkPointsOn(*graph, prior_map.level);
  const std::vector<closure::SightedDoor> sighted =
      closure::FindSightedDoors(doors.plan, graph->graph(), services.options.closure);
  const std::size_t count = doors.plan.doors.size();
  const auto begin = std::min(count, static_cast<std::size_t>(std::max<std::int64_t>(first, 0)));
  const std::size_t end = std::min(count, begin + static_cast<std::size_t>(size));
  for (std::size_t i = begin; i < end; ++i) {
    v1::PredictedLinkPoint door = DoorToProto(doors.plan.doors[i], static_cast<int>(i), doors.seen[i]);
    AddLinkPoint(known, name.site, door);
    AddSightings(sighted[i], name.site, joins, door);
    *response.add_predicted() = std::move(door);
  }
  if (end < count) response.set_next_page_token(ToPageToken(std::to_string(end)));
  return response;
}

}  // namespace enfilade::server
