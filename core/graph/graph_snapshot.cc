// SPDX-License-Identifier: Apache-2.0
#include "core/graph/graph_snapshot.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/validate_link_point.h"

namespace enfilade::graph {
namespace {

std::size_t Index(int slot) { return static_cast<std::size_t>(slot); }

// An unused slot.
template <typename Node>
int TakeSlot(CowVector<Node>& nodes, std::vector<int>& free) {
  if (free.empty()) {
    nodes.Append();
    return static_cast<int>(nodes.size()) - 1;
  }
  const int slot = free.back();
  free.pop_back();
  return slot;
}

template <typename Value, typename Nodes, typename Get>
std::vector<const Value*> List(const Nodes& nodes, const Get& get) {
  std::vector<const Value*> values;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (const Value* value = get(nodes[i])) values.push_back(value);
  }
  std::sort(values.begin(), values.end(), [](const Value* a, const Value* b) { return a->id < b->id; });
  return values;
}

bool JoinsMaps(const LinkPoint& link_point) {
  return link_point.use == LinkPointUse::kUsed && !link_point.is_candidate();
}

}  // namespace

const MapInGraph* GraphSnapshot::FindMap(const MapId& id) const {
  const int slot = map_index_.Find(id);
  return slot < 0 ? nullptr : maps_[Index(slot)].map.get();
}

const PoseWithCovariance* GraphSnapshot::FindSolvedPose(const MapId& map) const {
  if (solution_ == nullptr || solution_->root != root_) return nullptr;
  const auto found = solution_->map_poses.find(map);
  return found == solution_->map_poses.end() ? nullptr : &found->second;
}

const LinkPoint* GraphSnapshot::FindLinkPoint(const LinkPointId& id) const {
  const int slot = link_point_index_.Find(id);
  return slot < 0 ? nullptr : link_points_[Index(slot)].link_point.get();
}

std::vector<const MapInGraph*> GraphSnapshot::ListMaps() const {
  return List<MapInGraph>(maps_, [](const MapNode& node) { return node.map.get(); });
}

std::vector<const LinkPoint*> GraphSnapshot::ListLinkPoints() const {
  return List<LinkPoint>(link_points_, [](const LinkPointNode& node) { return node.link_point.get(); });
}

std::vector<const LinkPoint*> GraphSnapshot::ListLinkPointsIn(const MapId& map) const {
  std::vector<const LinkPoint*> found;
  const int slot = map_index_.Find(map);
  if (slot < 0) return found;
  for (const int link_point : maps_[Index(slot)].link_points) {
    found.push_back(link_points_[Index(link_point)].link_point.get());
  }
  std::sort(found.begin(), found.end(), [](const LinkPoint* a, const LinkPoint* b) { return a->id < b->id; });
  return found;
}

void GraphSnapshot::Upsert(const MapInGraph& map) {
  int slot = map_index_.Find(map.id);
  if (slot < 0) {
    slot = TakeSlot(maps_, free_maps_);
    map_index_.Insert(map.id, slot);
  }
  maps_.Mutable(Index(slot)).map = std::make_shared<const MapInGraph>(map);
}

absl::Status GraphSnapshot::Upsert(const LinkPoint& link_point) {
  ENFILADE_RETURN_IF_ERROR(ValidateLinkPoint(link_point));
  absl::InlinedVector<int, 2> maps;
  for (const Anchor& anchor : link_point.anchors) {
    maps.push_back(map_index_.Find(anchor.map));
    if (maps.back() < 0) {
      return InvalidArgument("link point {} has an anchor in map {}, which does not exist", link_point.id.value(),
                             anchor.map.value());
    }
  }
  int slot = link_point_index_.Find(link_point.id);
  if (slot < 0) {
    slot = TakeSlot(link_points_, free_link_points_);
    link_point_index_.Insert(link_point.id, slot);
  } else {
    Disconnect(slot);
  }
  LinkPointNode& node = link_points_.Mutable(Index(slot));
  node.link_point = std::make_shared<const LinkPoint>(link_point);
  node.maps = std::move(maps);
  node.state = link_point.state;
  node.state_valid_until = link_point.state_valid_until;
  Connect(slot);
  return absl::OkStatus();
}

absl::Status GraphSnapshot::Remove(const MapId& id) {
  const int slot = map_index_.Find(id);
  if (slot < 0) return absl::OkStatus();
  const MapNode& node = maps_[Index(slot)];
  if (!node.link_points.empty()) {
    return FailedPrecondition("map {} has {} link points, {} among them", id.value(), node.link_points.size(),
                              link_points_[Index(node.link_points.front())].link_point->id.value());
  }
  maps_.Mutable(Index(slot)) = {};
  map_index_.Erase(id);
  free_maps_.push_back(slot);
  return absl::OkStatus();
}

void GraphSnapshot::Remove(const LinkPointId& id) {
  const int slot = link_point_index_.Find(id);
  if (slot < 0) return;
  Disconnect(slot);
  link_points_.Mutable(Index(slot)) = {};
  link_point_index_.Erase(id);
  free_link_points_.push_back(slot);
}

// Adds the link point to its maps.
void GraphSnapshot::Connect(int slot) {
  const LinkPointNode& node = link_points_[Index(slot)];
  const LinkPoint& link_point = *node.link_point;
  for (std::size_t i = 0; i < node.maps.size(); ++i) {
    MapNode& map = maps_.Mutable(Index(node.maps[i]));
    map.link_points.push_back(slot);
    if (!JoinsMaps(link_point)) continue;
    const Anchor& anchor = link_point.anchors[i];
    const auto before = [this](const Doorway& a, const LinkPointId& id) {
      return link_points_[Index(a.link_point)].link_point->id < id;
    };
    const auto at = std::lower_bound(map.doorways.begin(), map.doorways.end(), link_point.id, before);
    map.doorways.insert(at, {.link_point = slot,
                             .x = anchor.T_map_place.x,
                             .y = anchor.T_map_place.y,
                             .position_spread = anchor.covariance(0, 0) + anchor.covariance(1, 1),
                             .yaw_variance = anchor.covariance(2, 2)});
  }
}

// Removes the link point from its maps.
void GraphSnapshot::Disconnect(int slot) {
  for (const int map_slot : link_points_[Index(slot)].maps) {
    MapNode& map = maps_.Mutable(Index(map_slot));
    std::erase(map.link_points, slot);
    std::erase_if(map.doorways, [slot](const Doorway& doorway) { return doorway.link_point == slot; });
  }
}

void GraphSnapshot::Freeze() {
  maps_.Freeze();
  link_points_.Freeze();
  map_index_.Freeze();
  link_point_index_.Freeze();
}

absl::StatusOr<GraphSnapshot> Apply(const GraphSnapshot& snapshot, const SnapshotChanges& changes) {
  GraphSnapshot next = snapshot;
  next.version_ = changes.version;
  for (const MapInGraph& map : changes.maps) next.Upsert(map);
  for (const LinkPointId& id : changes.removed_link_points) next.Remove(id);
  for (const LinkPoint& link_point : changes.link_points) ENFILADE_RETURN_IF_ERROR(next.Upsert(link_point));
  for (const MapId& id : changes.removed_maps) ENFILADE_RETURN_IF_ERROR(next.Remove(id));
  if (changes.solution != nullptr) next.solution_ = changes.solution;
  if (changes.plans) next.plans_ = *changes.plans;
  if (changes.root.has_value()) next.root_ = *changes.root;
  if (next.root_.empty() && !changes.maps.empty()) next.root_ = changes.maps.front().id;
  if (!next.root_.empty() && next.MapSlot(next.root_) < 0) next.root_ = MapId();
  next.Freeze();
  return next;
}

}  // namespace enfilade::graph
