// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "nlohmann/json.hpp"
#include "proto/convert/geometry.h"
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
    if (!is_on_level) continue;
    const auto place = graph::FindInWorld(graph.poses, *link_point);
    if (place) placed.push_back({link_point->id, place->pose.translation()});
  }
  return placed;
}

// The doors of a walls.geojson, in its order. DATA_LOSS.
absl::StatusOr<std::vector<v1::PredictedLinkPoint>> DoorsOf(const std::string& bytes) {
  const nlohmann::json document = nlohmann::json::parse(bytes, nullptr, /*allow_exceptions=*/false);
  std::vector<v1::PredictedLinkPoint> doors;
  try {
    for (const nlohmann::json& feature : document.at("features")) {
      const nlohmann::json& properties = feature.at("properties");
      if (properties.at("kind") != "door") continue;
      const auto ends = feature.at("geometry").at("coordinates").get<std::vector<std::vector<double>>>();
      const Eigen::Vector2d from(ends.at(0).at(0), ends.at(0).at(1)), to(ends.at(1).at(0), ends.at(1).at(1));
      const Eigen::Vector2d through(from.y() - to.y(), to.x() - from.x());
      v1::PredictedLinkPoint& door = doors.emplace_back();
      door.set_door(static_cast<int>(doors.size()) - 1);
      *door.mutable_pose_world_place() = convert::ToProto(
          Pose2{0.5 * (from.x() + to.x()), 0.5 * (from.y() + to.y()), std::atan2(through.y(), through.x())});
      door.set_width_m((to - from).norm());
      door.set_sigma_m(properties.at("sigma_m"));
      door.set_seen(properties.at("state") == "seen");
    }
  } catch (const std::exception& error) {
    return DataLoss("walls.geojson is damaged: {}", error.what());
  }
  return doors;
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
      ReadProductFile(services, call, name, storage::PriorMapProduct::kCorrected, "walls.geojson"));
  ENFILADE_ASSIGN_OR_RETURN(const storage::PriorMap prior_map,
                            services.prior_maps.Get(call.context(), name.site, name.prior_map));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<v1::PredictedLinkPoint> doors, DoorsOf(walls));
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(call.context(), name.site));
  const std::vector<PlacedLinkPoint> known = LinkPointsOn(*graph, prior_map.level);
  const auto begin = std::min(doors.size(), static_cast<std::size_t>(std::max<std::int64_t>(first, 0)));
  const std::size_t end = std::min(doors.size(), begin + static_cast<std::size_t>(size));
  for (std::size_t i = begin; i < end; ++i) {
    const v1::Pose2& place = doors[i].pose_world_place();
    double least = std::max(kLeastReach, kReachSigmas * doors[i].sigma_m());
    for (const PlacedLinkPoint& one : known) {
      const double distance = (one.position - Eigen::Vector2d(place.x(), place.y())).norm();
      if (distance > least) continue;
      least = distance;
      doors[i].set_link_point(NameOf(name.site, one.id));
    }
    *response.add_predicted() = std::move(doors[i]);
  }
  if (end < doors.size()) response.set_next_page_token(ToPageToken(std::to_string(end)));
  return response;
}

}  // namespace enfilade::server
