// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/graph/cow_index.h"
#include "core/graph/cow_vector.h"
#include "core/graph/link_point.h"
#include "core/graph/plans/plan_ties.h"
#include "core/graph/solved_graph.h"

namespace enfilade::graph {

// A map as part of the graph.
struct MapInGraph {
  MapId id = {};
  std::string display_name = {};
  int level = 0;
  std::vector<Eigen::Vector2d> outline = {};  // m, map frame; may be empty

  friend bool operator==(const MapInGraph&, const MapInGraph&) = default;
};

// The difference between two versions of a site's graph. The lists are applied in this order, so maps precede the link
// points with anchors in them; if an id is in several lists, the last one takes effect.
struct SnapshotChanges {
  std::int64_t version = 0;        // after the changes
  std::optional<MapId> root = {};  // the map whose frame is the world's; unset: unchanged
  std::vector<MapInGraph> maps = {};
  std::vector<LinkPointId> removed_link_points = {};
  std::vector<LinkPoint> link_points = {};
  std::vector<MapId> removed_maps = {};
  std::shared_ptr<const SolvedGraph> solution = {};    // null: unchanged
  std::optional<std::vector<PlanInGraph>> plans = {};  // all, by id; unset: unchanged
};

// The topological graph of one site at one version: maps, link points, floor plans and the optimised poses of maps, if
// any. Two link points are connected by an edge for each map in which both have an anchor; edges are not stored but
// follow from the maps' link points. Immutable, and cheap to copy and to change: versions share what is equal, so
// readers keep theirs while the next one is made.
//
// Link points are identified by their ids. The numbers of maps and link points below ("slots") are for searches within
// one snapshot and have no meaning in another.
class GraphSnapshot {
 public:
  // A link point in use that joins at least two maps, as seen from one of them.
  struct Doorway {
    int link_point = 0;            // slot
    double x = 0.0;                // m, map frame
    double y = 0.0;                // m
    double position_spread = 0.0;  // the trace of the anchor's position covariance, m^2
    double yaw_variance = 0.0;     // rad^2
  };
  struct MapNode {
    std::shared_ptr<const MapInGraph> map;  // null: an empty slot
    std::vector<Doorway> doorways;          // by link point's id
    std::vector<int> link_points;           // slots of all with an anchor here, including candidates and unused ones
  };
  struct LinkPointNode {
    std::shared_ptr<const LinkPoint> link_point;  // null: an empty slot
    absl::InlinedVector<int, 2> maps;             // slots, in the order of the anchors
    PassageState state = PassageState::kOpen;     // as in `link_point`, for searches
    std::optional<TimeNs> state_valid_until;
  };

  std::int64_t version() const { return version_; }
  // Empty if there are no maps.
  const MapId& root() const { return root_; }
  // Null if the graph was never optimised.
  const SolvedGraph* solution() const { return solution_.get(); }
  // T_world_map of a solution with the current root; null if there is none.
  const PoseWithCovariance* FindSolvedPose(const MapId& map) const;

  // The floor plans in use, by id.
  const std::vector<PlanInGraph>& plans() const { return plans_; }

  std::size_t map_count() const { return map_index_.size(); }
  std::size_t link_point_count() const { return link_point_index_.size(); }

  // Null if absent; valid as long as this snapshot or one that shares it.
  const MapInGraph* FindMap(const MapId& id) const;
  const LinkPoint* FindLinkPoint(const LinkPointId& id) const;
  // Sorted by id.
  std::vector<const MapInGraph*> ListMaps() const;
  std::vector<const LinkPoint*> ListLinkPoints() const;
  // Those with an anchor in the map, candidates and unused ones included, sorted by id. Empty if there is no such map.
  // The cost does not depend on the size of the graph.
  std::vector<const LinkPoint*> ListLinkPointsIn(const MapId& map) const;

  // -1 if absent.
  int MapSlot(const MapId& id) const { return map_index_.Find(id); }
  int LinkPointSlot(const LinkPointId& id) const { return link_point_index_.Find(id); }
  std::size_t map_slots() const { return maps_.size(); }
  std::size_t link_point_slots() const { return link_points_.size(); }
  const MapNode& map_node(int slot) const { return maps_[static_cast<std::size_t>(slot)]; }
  const LinkPointNode& link_point_node(int slot) const { return link_points_[static_cast<std::size_t>(slot)]; }

 private:
  friend absl::StatusOr<GraphSnapshot> Apply(const GraphSnapshot& snapshot, const SnapshotChanges& changes);

  void Upsert(const MapInGraph& map);
  absl::Status Upsert(const LinkPoint& link_point);
  absl::Status Remove(const MapId& id);
  void Remove(const LinkPointId& id);
  void Connect(int link_point);
  void Disconnect(int link_point);
  void Freeze();

  std::int64_t version_ = 0;
  MapId root_;
  std::shared_ptr<const SolvedGraph> solution_;
  std::vector<PlanInGraph> plans_;
  CowVector<MapNode> maps_;
  CowVector<LinkPointNode> link_points_;
  CowIndex<MapId> map_index_;
  CowIndex<LinkPointId> link_point_index_;
  std::vector<int> free_maps_;
  std::vector<int> free_link_points_;
};

// The next version. The cost is proportional to the changes and the link points of the affected maps, and grows very
// slowly with the graph. Removing an absent id is a no-op; without a root the first map becomes the root.
// INVALID_ARGUMENT: a link point that ValidateLinkPoint refuses, or an anchor in an unknown map. FAILED_PRECONDITION: a
// removed map still has link points.
absl::StatusOr<GraphSnapshot> Apply(const GraphSnapshot& snapshot, const SnapshotChanges& changes);

}  // namespace enfilade::graph
