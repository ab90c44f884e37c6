// SPDX-License-Identifier: Apache-2.0
#include "core/closure/graph_search.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "core/base/status_macros.h"
#include "core/closure/joined_anchors.h"
#include "core/closure/known_places.h"
#include "core/closure/near_door.h"
#include "core/graph/search_radius.h"

namespace enfilade::closure {
namespace {

// The other side of a link point of the session's map: on the entered level, the latest anchor if there are several;
// otherwise the first one. None if the robot has come to another level on which the link point has no anchor: the doors
// of a lift are above each other.
const graph::Anchor* FindOtherSide(const DoorKnowledge& knowledge, const graph::LinkPoint& link_point) {
  const bool another_level = knowledge.entered_level() != knowledge.map->level;
  const graph::Anchor* other = nullptr;
  for (const graph::Anchor& anchor : link_point.anchors) {
    if (anchor.map == knowledge.map->id) continue;
    const bool entered = IsOnEnteredLevel(knowledge, anchor.map);
    if (another_level && !entered) continue;
    if (other == nullptr || entered) other = &anchor;
  }
  return other;
}

ComparedPlace MakePlace(const graph::LinkPoint& link_point, const graph::Anchor& anchor) {
  ComparedPlace place{.link_point = &link_point, .anchor = &anchor};
  place.evidence.link_point = link_point.id;
  place.evidence.map = anchor.map;
  return place;
}

}  // namespace

PassedDoor FindPassedDoor(const DoorKnowledge& knowledge) {
  PassedDoor passed;
  for (KnownPlace& known : FindPassed(knowledge.graph->ListLinkPointsIn(knowledge.map->id), knowledge.map->id,
                                      *knowledge.T_map_door, knowledge.options)) {
    const graph::LinkPoint& link_point = *known.link_point;
    if (link_point.is_candidate()) {
      passed.sightings.push_back(link_point.id);
      continue;
    }
    const graph::Anchor* other = FindOtherSide(knowledge, link_point);
    if (other == nullptr) continue;
    ComparedPlace place = MakePlace(link_point, *other);
    place.evidence.distance = known.distance;
    place.evidence.predicted = PoseAcross(link_point, knowledge.map->id, other->map, *knowledge.T_map_robot);
    passed.link_points.push_back({.known = std::move(known), .place = std::move(place)});
  }
  // In a lift's cabin the doors of all levels are at one place.
  const auto elsewhere = [&](const PassedLinkPoint& one) {
    return !IsOnEnteredLevel(knowledge, one.place.anchor->map);
  };
  if (!std::all_of(passed.link_points.begin(), passed.link_points.end(), elsewhere)) {
    std::erase_if(passed.link_points, elsewhere);
  }
  return passed;
}

absl::Status GraphSearch::Run(const SearchGraph& step, DoorKnowledge& knowledge) {
  switch (step.target) {
    case SearchGraph::Target::kPassedDoor:
      knowledge.passed = FindPassedDoor(knowledge);
      return absl::OkStatus();
    case SearchGraph::Target::kPlaces: {
      ENFILADE_ASSIGN_OR_RETURN(knowledge.places, FindPlaces(knowledge));
      return absl::OkStatus();
    }
    case SearchGraph::Target::kMaps: {
      ENFILADE_ASSIGN_OR_RETURN(knowledge.maps, FindMaps(knowledge));
      return absl::OkStatus();
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<graph::TransformsTo*> GraphSearch::TransformsToSessionMap(const DoorKnowledge& knowledge) {
  if (!transforms_) {
    ENFILADE_ASSIGN_OR_RETURN(auto transforms, graph::TransformsTo::Make(*knowledge.graph, knowledge.map->id));
    transforms_ = std::move(transforms);
  }
  return &*transforms_;
}

// Within the search radius of the door, and all in maps that no link points lead to. The nearest first, max_compared at
// most.
absl::StatusOr<std::vector<ComparedPlace>> GraphSearch::FindPlaces(const DoorKnowledge& knowledge) {
  ENFILADE_ASSIGN_OR_RETURN(graph::TransformsTo * to_this, TransformsToSessionMap(knowledge));
  const std::vector<const graph::LinkPoint*> near = FindNear(knowledge);
  std::vector<MapId> maps;
  for (const graph::LinkPoint* link_point : near) {
    for (const graph::Anchor& anchor : link_point->anchors) {
      if (MayBeEntered(knowledge, anchor)) maps.push_back(anchor.map);
    }
  }
  ENFILADE_RETURN_IF_ERROR(to_this->Expect(maps));
  std::map<MapId, std::optional<PoseWithCovariance>> transforms;  // T_other_this
  std::vector<ComparedPlace> places;
  for (const graph::LinkPoint* link_point : near) {
    for (const graph::Anchor& anchor : link_point->anchors) {
      if (!MayBeEntered(knowledge, anchor)) continue;
      auto [found, is_new] = transforms.try_emplace(anchor.map);
      if (is_new) {
        ENFILADE_ASSIGN_OR_RETURN(const auto transform, to_this->Find(anchor.map));
        if (transform) found->second = transform->T_a_b;
      }
      ComparedPlace place = MakePlace(*link_point, anchor);
      if (found->second) {
        const PoseWithCovariance door = Compose(*found->second, *knowledge.T_map_door);
        place.evidence.predicted = Compose(*found->second, *knowledge.T_map_robot);
        place.evidence.distance = (door.pose.translation() - anchor.T_map_place.translation()).norm();
        const double radius =
            graph::SearchRadius(door.covariance + anchor.covariance, RadiusOptions(knowledge.options));
        if (*place.evidence.distance > radius) continue;
      }
      places.push_back(std::move(place));
    }
  }
  std::stable_sort(places.begin(), places.end(), [](const ComparedPlace& a, const ComparedPlace& b) {
    constexpr double kNowhere = std::numeric_limits<double>::infinity();
    return a.evidence.distance.value_or(kNowhere) < b.evidence.distance.value_or(kNowhere);
  });
  const auto limit = static_cast<std::size_t>(knowledge.options.max_compared);
  if (places.size() > limit) places.erase(places.begin() + static_cast<std::ptrdiff_t>(limit), places.end());
  return places;
}

// With a link point within the search radius of the predicted pose, by id; of more than max_searched the nearest. Maps
// that no link points lead to are left out: scans alone do not tell one room from another.
absl::StatusOr<std::vector<SearchedMap>> GraphSearch::FindMaps(const DoorKnowledge& knowledge) {
  ENFILADE_ASSIGN_OR_RETURN(graph::TransformsTo * to_this, TransformsToSessionMap(knowledge));
  const std::vector<const graph::MapInGraph*> looked_at = FindMapsNear(knowledge);
  std::vector<MapId> ids;
  for (const graph::MapInGraph* map : looked_at) ids.push_back(map->id);
  ENFILADE_RETURN_IF_ERROR(to_this->Expect(ids));
  const graph::GraphSnapshot& graph = *knowledge.graph;
  std::vector<std::pair<double, SearchedMap>> near;  // how far the nearest link point is
  for (const graph::MapInGraph* map : looked_at) {
    ENFILADE_ASSIGN_OR_RETURN(const auto transform, to_this->Find(map->id));
    if (!transform) continue;
    const PoseWithCovariance robot = Compose(transform->T_a_b, *knowledge.T_map_robot);
    double nearest = std::numeric_limits<double>::infinity();
    for (const int link_point : graph.map_node(graph.MapSlot(map->id)).link_points) {
      const graph::Anchor& anchor = *graph.link_point_node(link_point).link_point->FindAnchor(map->id);
      nearest = std::min(nearest, (anchor.T_map_place.translation() - robot.pose.translation()).norm());
    }
    if (nearest <= graph::SearchRadius(robot.covariance, RadiusOptions(knowledge.options))) {
      near.push_back({nearest, {.map = map, .predicted = robot}});
    }
  }
  const auto limit = static_cast<std::size_t>(knowledge.options.max_searched);
  if (near.size() > limit) {
    std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    near.resize(limit);
    std::sort(near.begin(), near.end(),
              [](const auto& a, const auto& b) { return a.second.map->id < b.second.map->id; });
  }
  std::vector<SearchedMap> maps;
  for (auto& [distance, map] : near) maps.push_back(std::move(map));
  return maps;
}

}  // namespace enfilade::closure
