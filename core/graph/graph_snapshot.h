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
#include "core/graph/solved_graph.h"

namespace enfilade::graph {

// What the graph knows of a map.
struct MapInGraph {
  MapId id = {};
  std::string display_name = {};
  int level = 0;
  std::vector<Eigen::Vector2d> outline = {};  // m, map frame; may be empty

  friend bool operator==(const MapInGraph&, const MapInGraph&) = default;
};

// What differs between two versions of a site's graph. Of an id that is in several lists the last one here counts:
// maps come before link points that have anchors in them.
struct SnapshotChanges {
  std::int64_t version = 0;        // after the changes
  std::optional<MapId> root = {};  // whose frame is the world's; unset: as before
  std::vector<MapInGraph> maps = {};
  std::vector<LinkPointId> removed_link_points = {};
  std::vector<LinkPoint> link_points = {};
  std::vector<MapId> removed_maps = {};
  std::shared_ptr<const SolvedGraph> solution = {};  // null: as before
};

// The topological graph of one site at one version: maps, link points and, where there is one, the optimised poses of
// maps. Two link points are joined by an edge for each map in which both have an anchor; edges are not stored but
// follow from the maps' link points. Immutable, and cheap to copy and to change: what is the same is shared, so that
// readers keep what they have while the next version is made from it.
//
// Link points are identified by their ids. The numbers of maps and link points below ("slots") are how searches find
// their way through one snapshot; they mean nothing in another.
class GraphSnapshot {
 public:
  // A link point that is in use and joins at least two maps, as one of them sees it.
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
    std::vector<int> link_points;           // slots of all that have an anchor here, candidates and unused ones too
  };
  struct LinkPointNode {
    std::shared_ptr<const LinkPoint> link_point;  // null: an empty slot
    absl::InlinedVector<int, 2> maps;             // slots, in the order of the anchors
    PassageState state = PassageState::kOpen;     // as in `link_point`, for searches
    std::optional<TimeNs> state_valid_until;
  };

  std::int64_t version() const { return version_; }
  // Empty where there is no map.
  const MapId& root() const { return root_; }
  // Null where nothing was optimised.
  const SolvedGraph* solution() const { return solution_.get(); }
  // T_world_map as solved from today's root; null where it was not.
  const PoseWithCovariance* FindSolvedPose(const MapId& map) const;

  std::size_t map_count() const { return map_index_.size(); }
  std::size_t link_point_count() const { return link_point_index_.size(); }

  // Null where it is not; valid as long as the snapshot or one that shares it.
  const MapInGraph* FindMap(const MapId& id) const;
  const LinkPoint* FindLinkPoint(const LinkPointId& id) const;
  // By id.
  std::vector<const MapInGraph*> ListMaps() const;
  std::vector<const LinkPoint*> ListLinkPoints() const;

  // -1 where it is not.
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
  void Join(int link_point);
  void Part(int link_point);
  void Freeze();

  std::int64_t version_ = 0;
  MapId root_;
  std::shared_ptr<const SolvedGraph> solution_;
  CowVector<MapNode> maps_;
  CowVector<LinkPointNode> link_points_;
  CowIndex<MapId> map_index_;
  CowIndex<LinkPointId> link_point_index_;
  std::vector<int> free_maps_;
  std::vector<int> free_link_points_;
};

// The next version. Its cost grows with the changes and the link points of the maps that they touch, and only very
// slowly with the graph. Removing what is not there is no error; without a root the first map becomes it.
// INVALID_ARGUMENT: a link point that ValidateLinkPoint refuses, or with an anchor in a map that is not there.
// FAILED_PRECONDITION: a removed map has link points still.
absl::StatusOr<GraphSnapshot> Apply(const GraphSnapshot& snapshot, const SnapshotChanges& changes);

}  // namespace enfilade::graph
