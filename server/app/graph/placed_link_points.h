// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/graph/cow_vector.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/point_index.h"
#include "storage/graph/graph_store.h"
#include "storage/graph/link_point_store.h"

namespace enfilade::server {

// The link points of one version of a site's graph as they are stored, and their places and those of the maps in the
// world. Searches in the world are answered from it, as LinkPointReader::Find and ListUnplaced do from the database.
// Immutable, and cheap to copy and to change, like GraphSnapshot, whose slots it shares. Thread-safe.
class PlacedLinkPoints {
 public:
  // What the store has changed since the version before; `after` is what graph::Apply made of the same changes and of
  // `before`. The whole graph if changes.complete: then `before` is empty, and so is this.
  PlacedLinkPoints With(const graph::GraphSnapshot& before, const graph::GraphSnapshot& after,
                        const storage::GraphChanges& changes) const;

  // T_world_map; unset: the map was never joined to the root map. `map`: a slot of the snapshot.
  const std::optional<PoseWithCovariance>& PlaceOfMap(int map) const {
    return map_places_[static_cast<std::size_t>(map)];
  }

  // As it is stored, by its slot, which must not be empty.
  const storage::StoredLinkPoint& Get(int slot) const { return Row(slot); }
  // T_world_place of a link point, by its slot; unset: its maps have no place.
  const std::optional<PoseWithCovariance>& PlaceOf(int link_point) const { return Row(link_point).T_world_place; }

  // In the order of LinkPointReader::Find. `graph` is the snapshot of this version. INVALID_ARGUMENT as there. The
  // pointers are valid as long as this.
  absl::StatusOr<std::vector<const storage::StoredLinkPoint*>> Find(const graph::GraphSnapshot& graph,
                                                                    const storage::LinkPointQuery& query) const;
  // m, in the world, by slot; of those that have a place.
  const graph::PointIndex& positions() const { return positions_; }
  // The slots of maps without a place in the world. `graph` is the snapshot of this version.
  std::vector<int> ListUnplacedMaps(const graph::GraphSnapshot& graph) const;
  // Those without a place in the world, by id. Looks at all link points, unless all have a place.
  std::vector<const storage::StoredLinkPoint*> ListUnplaced(int limit) const;

 private:
  const storage::StoredLinkPoint& Row(int slot) const { return *rows_[static_cast<std::size_t>(slot)]; }
  void Set(int slot, std::shared_ptr<const storage::StoredLinkPoint> row, std::vector<graph::PointIndex::Point>& moved);

  graph::CowVector<std::shared_ptr<const storage::StoredLinkPoint>> rows_;  // null: an empty slot
  graph::CowVector<std::optional<PoseWithCovariance>> map_places_;
  // Whether map_places_ has none, by slot: a scan of bytes is quick.
  graph::CowVector<std::uint8_t> has_no_place_;
  graph::PointIndex positions_;
  int unplaced_ = 0;
};

}  // namespace enfilade::server
