// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point.h"

namespace enfilade::graph {

// First estimates of where link points and maps lie in the world, for the time until the graph is optimised. A link
// point lies where its best anchor says: the one in a placed map that gives the smallest trace of its position's
// covariance in the world. A link point in use then places those of its maps that have no place. They let further link
// points be placed, and so on: feed those to Visit until it returns no more maps.
//
//   Placement placement;
//   for (link_points = {changed}; !link_points.empty(); link_points = ReadUnplacedAt(maps)) {
//     for (map in placement.UnknownMapsOf(link_points)) if it has a place: placement.SetPlace(map, place);
//     maps = placement.Visit(link_points);
//   }
//
// The caller reads rows in between because only it knows which of them are worth reading.
class Placement {
 public:
  using PlacedMap = std::pair<MapId, PoseWithCovariance>;

  // The maps that `link_points` join and whose places have not been set or found, by id.
  std::vector<MapId> UnknownMapsOf(std::span<const LinkPoint> link_points) const;
  // The known place of a map.
  void SetPlace(const MapId& map, const PoseWithCovariance& T_world_map);

  // Places those of `link_points` that have an anchor in a placed map, in their order, each once. Returns the maps that
  // got a place by it.
  std::vector<MapId> Visit(std::span<const LinkPoint> link_points);

  // T_world_map of the maps that Visit has placed, in the order of their discovery.
  const std::vector<PlacedMap>& maps() const { return maps_; }
  // T_world_place of the link points that Visit has placed.
  const std::map<LinkPointId, PoseWithCovariance>& link_points() const { return link_points_; }

 private:
  std::map<MapId, PoseWithCovariance> places_;  // known or found
  std::vector<PlacedMap> maps_;
  std::map<LinkPointId, PoseWithCovariance> link_points_;
};

}  // namespace enfilade::graph
