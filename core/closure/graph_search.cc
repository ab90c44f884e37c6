// SPDX-License-Identifier: Apache-2.0
#include "core/closure/graph_search.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/base/status_macros.h"
#include "core/closure/joined_anchors.h"
#include "core/closure/known_places.h"
#include "core/graph/search_radius.h"

namespace enfilade::closure {
namespace {

using graph::GraphSnapshot;

graph::SearchRadiusOptions RadiusOptions(const DoorClosureOptions& options) {
  return {.base_m = options.search_base, .factor = options.search_factor};
}

bool IsOnEnteredLevel(const DoorKnowledge& knowledge, const MapId& map) {
  const graph::MapInGraph* found = knowledge.graph->FindMap(map);
  return found != nullptr && found->level == knowledge.entered_level();
}

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

// Can the place be where a passage led: is it on the entered level of another map, in use, and not refused before?
bool MayBeEntered(const DoorKnowledge& knowledge, const graph::LinkPoint& link_point) {
  if (link_point.use == graph::LinkPointUse::kSuspended) return false;
  if (link_point.is_candidate()) return !knowledge.redundant.contains(link_point.id);
  // Those of this very door have been contradicted, or the search would not have got here.
  const std::vector<PassedLinkPoint>& passed = knowledge.passed->link_points;
  return std::none_of(passed.begin(), passed.end(),
                      [&](const PassedLinkPoint& one) { return one.place.link_point == &link_point; });
}

// T_world_map by the solution: of a map that it does not pose, from the posed map that is the fewest link points away.
// Unset if there is none.
std::optional<PoseWithCovariance> FindWorldPose(const GraphSnapshot& graph, int map) {
  std::vector<std::pair<int, PoseWithCovariance>> queue = {{map, {}}};  // T_reached_map
  std::set<int> reached = {map};
  for (std::size_t i = 0; i < queue.size(); ++i) {
    const auto [here, T_here_map] = queue[i];
    const MapId& id = graph.map_node(here).map->id;
    if (const PoseWithCovariance* T_world_here = graph.FindSolvedPose(id)) return Compose(*T_world_here, T_here_map);
    for (const GraphSnapshot::Doorway& doorway : graph.map_node(here).doorways) {
      const GraphSnapshot::LinkPointNode& node = graph.link_point_node(doorway.link_point);
      for (const int there : node.maps) {
        if (!reached.insert(there).second) continue;
        const graph::Anchor& to = *node.link_point->FindAnchor(graph.map_node(there).map->id);
        const graph::Anchor& from = *node.link_point->FindAnchor(id);
        queue.emplace_back(there, Compose(graph::TransformAcross(to, from), T_here_map));
      }
    }
  }
  return std::nullopt;
}

// What lies near the session's map by the poses of the graph's solution. Chains of link points say it more exactly, but
// each of them costs a search. Variances of the solution add up to an upper bound of the transform's.
class SolvedNeighbourhood {
 public:
  explicit SolvedNeighbourhood(const DoorKnowledge& knowledge)
      : knowledge_(knowledge),
        options_(RadiusOptions(knowledge.options)),
        T_world_this_(FindWorldPose(*knowledge.graph, knowledge.graph->MapSlot(knowledge.map->id))) {}

  // Whether the door may be within the search radius of the anchor. Yes, if the solution does not pose the map.
  bool MayBeNear(const graph::Anchor& anchor) const {
    const auto door = PoseIn(anchor.map, *knowledge_.T_map_door);
    return !door || Distance(*door, anchor) <= graph::SearchRadius(door->covariance + anchor.covariance, options_);
  }

  // Whether the robot may be within the search radius of one of the map's link points. As MayBeNear.
  bool MayBeNear(const GraphSnapshot::MapNode& node) const {
    const auto robot = PoseIn(node.map->id, *knowledge_.T_map_robot);
    if (!robot) return true;
    const double radius = graph::SearchRadius(robot->covariance, options_);
    return std::any_of(node.link_points.begin(), node.link_points.end(), [&](int link_point) {
      const graph::LinkPoint& point = *knowledge_.graph->link_point_node(link_point).link_point;
      return Distance(*robot, *point.FindAnchor(node.map->id)) <= radius;
    });
  }

 private:
  std::optional<PoseWithCovariance> PoseIn(const MapId& map, const PoseWithCovariance& T_this_pose) const {
    const PoseWithCovariance* T_world_map = knowledge_.graph->FindSolvedPose(map);
    if (!T_world_this_ || T_world_map == nullptr) return std::nullopt;
    return Compose(Inverse(*T_world_map), Compose(*T_world_this_, T_this_pose));
  }
  static double Distance(const PoseWithCovariance& pose, const graph::Anchor& anchor) {
    return (pose.pose.translation() - anchor.T_map_place.translation()).norm();
  }

  const DoorKnowledge& knowledge_;
  const graph::SearchRadiusOptions options_;
  const std::optional<PoseWithCovariance> T_world_this_;
};

// Link points that the search for places looks at, by id.
std::vector<const graph::LinkPoint*> FindNear(const DoorKnowledge& knowledge) {
  const GraphSnapshot& graph = *knowledge.graph;
  const SolvedNeighbourhood neighbourhood(knowledge);
  std::vector<const graph::LinkPoint*> near;
  for (std::size_t slot = 0; slot < graph.link_point_slots(); ++slot) {
    const graph::LinkPoint* link_point = graph.link_point_node(static_cast<int>(slot)).link_point.get();
    if (link_point == nullptr) continue;
    const auto& anchors = link_point->anchors;
    if (std::any_of(anchors.begin(), anchors.end(),
                    [&](const graph::Anchor& anchor) { return neighbourhood.MayBeNear(anchor); })) {
      near.push_back(link_point);
    }
  }
  std::sort(near.begin(), near.end(), [](const auto* a, const auto* b) { return a->id < b->id; });
  return near;
}

// Other maps on the entered level that the search for maps looks at, by id.
std::vector<const graph::MapInGraph*> FindMapsNear(const DoorKnowledge& knowledge) {
  const GraphSnapshot& graph = *knowledge.graph;
  const SolvedNeighbourhood neighbourhood(knowledge);
  std::vector<const graph::MapInGraph*> near;
  for (std::size_t slot = 0; slot < graph.map_slots(); ++slot) {
    const GraphSnapshot::MapNode& node = graph.map_node(static_cast<int>(slot));
    if (node.map == nullptr || node.map->id == knowledge.map->id) continue;
    if (node.map->level == knowledge.entered_level() && neighbourhood.MayBeNear(node)) near.push_back(node.map.get());
  }
  std::sort(near.begin(), near.end(), [](const auto* a, const auto* b) { return a->id < b->id; });
  return near;
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
  std::map<MapId, std::optional<PoseWithCovariance>> transforms;  // T_other_this
  std::vector<ComparedPlace> places;
  for (const graph::LinkPoint* link_point : FindNear(knowledge)) {
    if (!MayBeEntered(knowledge, *link_point)) continue;
    for (const graph::Anchor& anchor : link_point->anchors) {
      if (anchor.map == knowledge.map->id || !IsOnEnteredLevel(knowledge, anchor.map)) continue;
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
  const graph::GraphSnapshot& graph = *knowledge.graph;
  std::vector<std::pair<double, SearchedMap>> near;  // how far the nearest link point is
  for (const graph::MapInGraph* map : FindMapsNear(knowledge)) {
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
  // A graph that is not sure of the robot's place predicts it in all maps for hundreds of metres around.
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
