// SPDX-License-Identifier: Apache-2.0
#include "core/closure/near_door.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>
#include <utility>

namespace enfilade::closure {
namespace {

using graph::GraphSnapshot;

// Can the place be where a passage led: is it on the entered level of another map, in use, and no candidate that was
// refused before?
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

// A graph that is not sure of the robot's place has it near everything for hundreds of metres around. So many of what
// it may be near to are looked at, the nearest first by the solution: several times as many as are compared or searched
// in.
constexpr std::size_t kLookedAt = 256;
// So many of the index are asked for: it tells a link point's place in one of its maps, and distances differ a little.
constexpr int kIndexed = 2 * kLookedAt;

// What lies near the session's map by the poses of the graph's solution. Chains of link points say it more exactly, but
// cost a search. Variances of the solution add up to an upper bound of the transform's.
class SolvedNeighbourhood {
 public:
  explicit SolvedNeighbourhood(const DoorKnowledge& knowledge)
      : knowledge_(knowledge),
        options_(RadiusOptions(knowledge.options)),
        T_world_this_(FindWorldPose(*knowledge.graph, knowledge.graph->MapSlot(knowledge.map->id))) {}

  // Where `T_this_pose` is in the world, m; unset: the solution does not tell.
  std::optional<Eigen::Vector2d> InWorld(const PoseWithCovariance& T_this_pose) const {
    if (!T_world_this_) return std::nullopt;
    return T_world_this_->pose * T_this_pose.pose.translation();
  }

  // How far the place is from `T_this_pose`, m, where the solution poses both maps.
  std::optional<double> Distance(const PoseWithCovariance& T_this_pose, const graph::Anchor& anchor) const {
    const PoseWithCovariance* T_world_map = knowledge_.graph->FindSolvedPose(anchor.map);
    const std::optional<Eigen::Vector2d> pose = InWorld(T_this_pose);
    if (!pose || T_world_map == nullptr) return std::nullopt;
    return (T_world_map->pose * anchor.T_map_place.translation() - *pose).norm();
  }

  // Whether the door may be within the search radius of the anchor, which is so far from it.
  bool MayBeNear(const graph::Anchor& anchor, double distance) const {
    const Eigen::Matrix3d door = CovarianceIn(anchor.map, *knowledge_.T_map_door);
    return distance <= graph::SearchRadius(door + anchor.covariance, options_);
  }

  // Whether the robot may be within the search radius of a link point of the map that is so far from it.
  bool MayBeNear(const graph::MapInGraph& map, double distance) const {
    return distance <= graph::SearchRadius(CovarianceIn(map.id, *knowledge_.T_map_robot), options_);
  }

 private:
  // Of the pose in a map that the solution poses.
  Eigen::Matrix3d CovarianceIn(const MapId& map, const PoseWithCovariance& T_this_pose) const {
    return Compose(Inverse(*knowledge_.graph->FindSolvedPose(map)), Compose(*T_world_this_, T_this_pose)).covariance;
  }

  const DoorKnowledge& knowledge_;
  const graph::SearchRadiusOptions options_;
  const std::optional<PoseWithCovariance> T_world_this_;
};

// Something that may be near. Without a distance it is looked at in any case.
template <typename Thing>
struct Found {
  std::optional<double> distance;
  const Thing* thing = nullptr;
};

// By id: those without a distance, and of the others the kLookedAt nearest.
template <typename Thing>
std::vector<Found<Thing>> Nearest(std::vector<Found<Thing>> found) {
  const auto far = std::partition(found.begin(), found.end(), [](const auto& one) { return !one.distance; });
  if (found.end() - far > static_cast<std::ptrdiff_t>(kLookedAt)) {
    const auto end = far + static_cast<std::ptrdiff_t>(kLookedAt);
    std::nth_element(far, end, found.end(), [](const auto& a, const auto& b) {
      return *a.distance != *b.distance ? *a.distance < *b.distance : a.thing->id < b.thing->id;
    });
    found.erase(end, found.end());
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.thing->id < b.thing->id; });
  return found;
}

// Whether the map is on the entered level, and another one than the session's.
bool MayBeEntered(const DoorKnowledge& knowledge, const graph::MapInGraph& map) {
  return map.level == knowledge.entered_level() && map.id != knowledge.map->id;
}

// Whether a map that may be entered has the link point.
bool HasEnterableAnchor(const DoorKnowledge& knowledge, const GraphSnapshot::LinkPointNode& node) {
  return std::any_of(node.maps.begin(), node.maps.end(),
                     [&](int map) { return MayBeEntered(knowledge, *knowledge.graph->map_node(map).map); });
}

std::vector<int> AllSlots(const GraphSnapshot& graph) {
  std::vector<int> slots;
  slots.reserve(graph.link_point_slots());
  for (std::size_t slot = 0; slot < graph.link_point_slots(); ++slot) {
    if (graph.link_point_node(static_cast<int>(slot)).link_point != nullptr) slots.push_back(static_cast<int>(slot));
  }
  return slots;
}

// Slots of the link points of which the index does not tell where each of their maps has them.
void AddUnsureSlots(const DoorKnowledge& knowledge, std::vector<int>& slots) {
  const GraphSnapshot& graph = *knowledge.graph;
  const auto add_all_in = [&](int map) {
    if (map < 0) return;
    const std::vector<int>& own = graph.map_node(map).link_points;
    slots.insert(slots.end(), own.begin(), own.end());
  };
  for (const int map : knowledge.world_index->unplaced_maps) add_all_in(map);
  for (const MapId& map : graph.solution()->disconnected) add_all_in(graph.MapSlot(map));
  for (const graph::SwitchedOff& off : graph.solution()->switched_off) {
    if (const int slot = graph.LinkPointSlot(off.link_point); slot >= 0) slots.push_back(slot);
  }
}

// Slots, each once, of at most `limit` link points that `accept` takes, the nearest to a place in the world, and of
// those that may be anywhere. All, if the solution does not tell the place or there is no index.
std::vector<int> SlotsAround(const DoorKnowledge& knowledge, const std::optional<Eigen::Vector2d>& in_world, int limit,
                             const graph::PointIndex::Filter& accept) {
  if (!knowledge.world_index || !in_world) return AllSlots(*knowledge.graph);
  std::vector<int> slots;
  AddUnsureSlots(knowledge, slots);
  constexpr double kAnywhere = std::numeric_limits<double>::infinity();
  for (const auto& neighbour : knowledge.world_index->positions->FindNearest(*in_world, kAnywhere, limit, accept)) {
    slots.push_back(neighbour.number);
  }
  std::sort(slots.begin(), slots.end());
  slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
  return slots;
}

// Slots of maps that may be entered and have link points: the kLookedAt nearest to the robot, or more, and those that
// may be anywhere.
std::set<int> MapsAround(const DoorKnowledge& knowledge, const std::optional<Eigen::Vector2d>& in_world) {
  const GraphSnapshot& graph = *knowledge.graph;
  const auto accept = [&](int slot) { return HasEnterableAnchor(knowledge, graph.link_point_node(slot)); };
  for (int limit = kIndexed;; limit *= 2) {
    const std::vector<int> slots = SlotsAround(knowledge, in_world, limit, accept);
    std::set<int> maps;
    for (const int slot : slots) {
      for (const int map : graph.link_point_node(slot).maps) {
        if (MayBeEntered(knowledge, *graph.map_node(map).map)) maps.insert(map);
      }
    }
    if (maps.size() >= kLookedAt || slots.size() < static_cast<std::size_t>(limit)) return maps;
  }
}

}  // namespace

graph::SearchRadiusOptions RadiusOptions(const DoorClosureOptions& options) {
  return {.base_m = options.search_base, .factor = options.search_factor};
}

bool IsOnEnteredLevel(const DoorKnowledge& knowledge, const MapId& map) {
  const graph::MapInGraph* found = knowledge.graph->FindMap(map);
  return found != nullptr && found->level == knowledge.entered_level();
}

bool MayBeEntered(const DoorKnowledge& knowledge, const graph::Anchor& anchor) {
  return anchor.map != knowledge.map->id && IsOnEnteredLevel(knowledge, anchor.map);
}

std::vector<const graph::LinkPoint*> FindNear(const DoorKnowledge& knowledge) {
  const GraphSnapshot& graph = *knowledge.graph;
  const SolvedNeighbourhood neighbourhood(knowledge);
  const auto accept = [&](int slot) {
    const GraphSnapshot::LinkPointNode& node = graph.link_point_node(slot);
    return MayBeEntered(knowledge, *node.link_point) && HasEnterableAnchor(knowledge, node);
  };
  std::vector<Found<graph::LinkPoint>> found;
  for (const int slot : SlotsAround(knowledge, neighbourhood.InWorld(*knowledge.T_map_door), kIndexed, accept)) {
    if (!accept(slot)) continue;
    const GraphSnapshot::LinkPointNode& node = graph.link_point_node(slot);
    const graph::LinkPoint* link_point = node.link_point.get();
    Found<graph::LinkPoint> one;
    for (std::size_t i = 0; i < node.maps.size(); ++i) {
      if (!MayBeEntered(knowledge, *graph.map_node(node.maps[i]).map)) continue;
      const graph::Anchor& anchor = link_point->anchors[i];
      const auto distance = neighbourhood.Distance(*knowledge.T_map_door, anchor);
      // One without a distance counts before all others.
      if (one.thing == nullptr || distance < one.distance) one = {distance, link_point};
    }
    found.push_back(one);
  }
  std::vector<const graph::LinkPoint*> near;
  for (const auto& one : Nearest(std::move(found))) {
    const auto& anchors = one.thing->anchors;
    if (!one.distance || std::any_of(anchors.begin(), anchors.end(), [&](const graph::Anchor& anchor) {
          if (!MayBeEntered(knowledge, anchor)) return false;
          return neighbourhood.MayBeNear(anchor, *neighbourhood.Distance(*knowledge.T_map_door, anchor));
        })) {
      near.push_back(one.thing);
    }
  }
  return near;
}

std::vector<const graph::MapInGraph*> FindMapsNear(const DoorKnowledge& knowledge) {
  const GraphSnapshot& graph = *knowledge.graph;
  const SolvedNeighbourhood neighbourhood(knowledge);
  std::vector<Found<graph::MapInGraph>> found;
  for (const int slot : MapsAround(knowledge, neighbourhood.InWorld(*knowledge.T_map_robot))) {
    const GraphSnapshot::MapNode& node = graph.map_node(slot);
    std::optional<Found<graph::MapInGraph>> one;
    for (const int link_point : node.link_points) {
      const graph::Anchor& anchor = *graph.link_point_node(link_point).link_point->FindAnchor(node.map->id);
      const auto distance = neighbourhood.Distance(*knowledge.T_map_robot, anchor);
      if (!one || distance < one->distance) one = {distance, node.map.get()};
    }
    if (one) found.push_back(*one);
  }
  std::vector<const graph::MapInGraph*> near;
  for (const auto& one : Nearest(std::move(found))) {
    if (!one.distance || neighbourhood.MayBeNear(*one.thing, *one.distance)) near.push_back(one.thing);
  }
  return near;
}

}  // namespace enfilade::closure
