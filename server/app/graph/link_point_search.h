// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/graph/search_radius.h"
#include "server/app/graph/site_graph.h"
#include "storage/graph/link_point_store.h"

namespace enfilade::server {

// Link points around a robot, a position or in an area. The rules of FindLinkPoints in
// proto/enfilade/v1/link_point_service.proto.

struct PoseInMap {
  MapId map;
  PoseWithCovariance T_map_robot;
};

struct LinkPointSearch {
  // A pose, in a map or in the world, is searched around as far as its uncertainty requires: graph::SearchRadius().
  std::variant<PoseInMap, PoseWithCovariance, storage::LinkPointCircle, std::vector<Eigen::Vector2d>> around;
  graph::SearchRadiusOptions radius = {};  // for a pose
  int limit = 1000;
  std::optional<int> level = {};       // unset: all
  std::optional<bool> candidate = {};  // unset: candidates and link points
  bool with_unused = false;            // suspended and switched off ones, too
  bool with_unplaced = false;          // those without a place in the world, too
};

// What a search looks for in the graph.
struct LinkPointSearchPlan {
  std::optional<storage::LinkPointQuery> query;      // unset: the pose's map has no place in the world
  std::optional<PoseWithCovariance> T_world_center;  // of a pose or circle
  bool with_unplaced = false;
};

// `T_world_map`: the place of a PoseInMap's map; unset if it has none, and ignored for other searches. INVALID_ARGUMENT
// if a number of `search.radius` is not positive and finite.
absl::StatusOr<LinkPointSearchPlan> PlanLinkPointSearch(const LinkPointSearch& search,
                                                        const std::optional<PoseWithCovariance>& T_world_map);

struct FoundLinkPoint {
  const storage::StoredLinkPoint* link_point = nullptr;
  // From the search's centre; unset if it has none or the link point has no place in the world.
  struct Offset {
    double distance_m = 0.0;
    double bearing_rad = 0.0;           // counter-clockwise from the world's x axis
    double mahalanobis_distance = 0.0;  // infinite if the covariances are singular
  };
  std::optional<Offset> offset;
};

// How far and in which direction the link point lies from the centre.
std::optional<FoundLinkPoint::Offset> OffsetFrom(const std::optional<PoseWithCovariance>& T_world_center,
                                                 const storage::StoredLinkPoint& link_point);

struct LinkPointSearchResult {
  std::shared_ptr<const SiteGraph> graph;  // that was searched; it owns the link points
  std::vector<FoundLinkPoint> found;       // those with a place first, in the order of LinkPointReader::Find()
  std::optional<PoseWithCovariance> T_world_center;
  std::optional<double> radius_m;  // of a search around something with a place
};

// As PlanLinkPointSearch, with the map's place in the graph. NOT_FOUND if the site has no such map.
absl::StatusOr<LinkPointSearchPlan> PlanLinkPointSearchIn(const SiteId& site, const SiteGraph& graph,
                                                          const LinkPointSearch& search);

// Answers from memory. INVALID_ARGUMENT as LinkPointReader::Find.
absl::StatusOr<LinkPointSearchResult> SearchLinkPoints(std::shared_ptr<const SiteGraph> graph,
                                                       const LinkPointSearchPlan& plan);

}  // namespace enfilade::server
