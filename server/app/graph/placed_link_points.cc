// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/placed_link_points.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

template <typename T>
T& Grown(graph::CowVector<T>& values, int slot) {
  const auto index = static_cast<std::size_t>(slot);
  while (values.size() <= index) values.Append();
  return values.Mutable(index);
}

bool IsUnplaced(const std::shared_ptr<const storage::StoredLinkPoint>& row) {
  return row != nullptr && !row->T_world_place;
}

// Whether the link point joins, or is seen from, a map on the level.
bool IsOnLevel(const graph::GraphSnapshot& graph, int link_point, int level) {
  const auto& maps = graph.link_point_node(link_point).maps;
  return std::any_of(maps.begin(), maps.end(), [&](int map) { return graph.map_node(map).map->level == level; });
}

void Truncate(std::vector<const storage::StoredLinkPoint*>& found, int limit) {
  if (found.size() > static_cast<std::size_t>(limit)) found.resize(static_cast<std::size_t>(limit));
}

bool HasLowerId(const storage::StoredLinkPoint* a, const storage::StoredLinkPoint* b) {
  return a->point.id < b->point.id;
}

}  // namespace

PlacedLinkPoints PlacedLinkPoints::With(const graph::GraphSnapshot& before, const graph::GraphSnapshot& after,
                                        const storage::GraphChanges& changes) const {
  PlacedLinkPoints next = *this;
  std::vector<graph::PointIndex::Point> moved;
  // A slot that a removed link point leaves may be another one's by now.
  for (const LinkPointId& id : changes.removed_link_points) {
    if (const int slot = before.LinkPointSlot(id); slot >= 0) next.Set(slot, nullptr, moved);
  }
  for (const storage::StoredLinkPoint& link_point : changes.link_points) {
    const int slot = after.LinkPointSlot(link_point.point.id);
    if (slot >= 0) next.Set(slot, std::make_shared<const storage::StoredLinkPoint>(link_point), moved);
  }
  for (const storage::GraphMap& map : changes.maps) {
    const int slot = after.MapSlot(map.id);
    if (slot < 0) continue;
    Grown(next.map_places_, slot) = map.T_world_map;
    Grown(next.has_no_place_, slot) = map.T_world_map ? 0 : 1;
  }
  next.positions_ = next.positions_.With(moved);
  next.rows_.Freeze();
  next.map_places_.Freeze();
  next.has_no_place_.Freeze();
  return next;
}

void PlacedLinkPoints::Set(int slot, std::shared_ptr<const storage::StoredLinkPoint> row,
                           std::vector<graph::PointIndex::Point>& moved) {
  std::shared_ptr<const storage::StoredLinkPoint>& place = Grown(rows_, slot);
  unplaced_ += static_cast<int>(IsUnplaced(row)) - static_cast<int>(IsUnplaced(place));
  place = std::move(row);
  graph::PointIndex::Point& point = moved.emplace_back(graph::PointIndex::Point{.number = slot});
  if (place != nullptr && place->T_world_place) point.position = place->T_world_place->pose.translation();
}

absl::StatusOr<std::vector<const storage::StoredLinkPoint*>> PlacedLinkPoints::Find(
    const graph::GraphSnapshot& graph, const storage::LinkPointQuery& query) const {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateQuery(query));
  const auto accept = [&](int slot) {
    const graph::LinkPoint& link_point = Row(slot).point;
    return (!query.candidate || link_point.is_candidate() == *query.candidate) &&
           (query.with_unused || link_point.use == graph::LinkPointUse::kUsed) &&
           (!query.level || IsOnLevel(graph, slot, *query.level));
  };
  std::vector<const storage::StoredLinkPoint*> found;
  if (const auto* circle = std::get_if<storage::LinkPointCircle>(&query.area)) {
    const auto neighbours = positions_.FindNearest(circle->center, circle->radius, query.limit, accept);
    for (auto it = neighbours.begin(); it != neighbours.end();) {
      const auto same = std::find_if(it, neighbours.end(), [&](const auto& n) { return n.distance != it->distance; });
      const auto begin = static_cast<std::ptrdiff_t>(found.size());
      for (; it != same; ++it) found.push_back(&Row(it->number));
      std::sort(found.begin() + begin, found.end(), HasLowerId);
    }
    return found;
  }
  for (const int slot : positions_.FindInPolygon(std::get<std::vector<Eigen::Vector2d>>(query.area), accept)) {
    found.push_back(&Row(slot));
  }
  std::sort(found.begin(), found.end(), HasLowerId);
  Truncate(found, query.limit);
  return found;
}

std::vector<int> PlacedLinkPoints::ListUnplacedMaps(const graph::GraphSnapshot& graph) const {
  std::vector<int> slots;
  for (std::size_t i = 0; i < has_no_place_.size(); ++i) {
    const int slot = static_cast<int>(i);
    if (has_no_place_[i] != 0 && graph.map_node(slot).map != nullptr) slots.push_back(slot);
  }
  return slots;
}

std::vector<const storage::StoredLinkPoint*> PlacedLinkPoints::ListUnplaced(int limit) const {
  std::vector<const storage::StoredLinkPoint*> found;
  for (std::size_t i = 0; i < rows_.size() && found.size() < static_cast<std::size_t>(unplaced_); ++i) {
    if (IsUnplaced(rows_[i])) found.push_back(rows_[i].get());
  }
  std::sort(found.begin(), found.end(), HasLowerId);
  Truncate(found, limit);
  return found;
}

}  // namespace enfilade::server
