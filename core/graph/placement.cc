// SPDX-License-Identifier: Apache-2.0
#include "core/graph/placement.h"

#include <optional>
#include <set>

namespace enfilade::graph {
namespace {

double PositionVariance(const PoseWithCovariance& pose) { return pose.covariance.topLeftCorner<2, 2>().trace(); }

std::optional<PoseWithCovariance> FindBestPlace(const LinkPoint& link_point,
                                                const std::map<MapId, PoseWithCovariance>& places) {
  std::optional<PoseWithCovariance> best;
  for (const Anchor& anchor : link_point.anchors) {
    const auto map = places.find(anchor.map);
    if (map == places.end()) continue;
    const PoseWithCovariance T_world_place = Compose(map->second, {anchor.T_map_place, anchor.covariance});
    if (!best || PositionVariance(T_world_place) < PositionVariance(*best)) best = T_world_place;
  }
  return best;
}

}  // namespace

std::vector<MapId> Placement::UnknownMapsOf(std::span<const LinkPoint> link_points) const {
  std::set<MapId> unknown;
  for (const LinkPoint& link_point : link_points) {
    for (const Anchor& anchor : link_point.anchors) {
      if (!places_.contains(anchor.map)) unknown.insert(anchor.map);
    }
  }
  return {unknown.begin(), unknown.end()};
}

void Placement::SetPlace(const MapId& map, const PoseWithCovariance& T_world_map) { places_[map] = T_world_map; }

std::vector<MapId> Placement::Visit(std::span<const LinkPoint> link_points) {
  std::vector<MapId> reached;
  for (const LinkPoint& link_point : link_points) {
    if (link_points_.contains(link_point.id)) continue;
    const std::optional<PoseWithCovariance> T_world_place = FindBestPlace(link_point, places_);
    if (!T_world_place) continue;
    link_points_.emplace(link_point.id, *T_world_place);
    if (link_point.use != LinkPointUse::kUsed) continue;
    for (const Anchor& anchor : link_point.anchors) {
      const auto [place, is_new] = places_.try_emplace(anchor.map);
      if (!is_new) continue;
      place->second = Compose(*T_world_place, Inverse(PoseWithCovariance{anchor.T_map_place, anchor.covariance}));
      maps_.emplace_back(anchor.map, place->second);
      reached.push_back(anchor.map);
    }
  }
  return reached;
}

}  // namespace enfilade::graph
