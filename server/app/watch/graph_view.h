// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "server/app/graph/site_graph.h"

namespace enfilade::server {

// What people see of a site's graph: its maps and link points with their places in the world, and when each last
// changed. A map moves with any link point on the way to it, so that this cannot be told from its own row. Immutable
// and shared; the pointers are valid as long as `graph`.
struct GraphView {
  struct Map {
    const graph::MapInGraph* map = nullptr;
    std::optional<PoseWithCovariance> T_world_map;  // unset: no link points join it to the root
    bool optimized = false;                         // its pose is the optimisation's, not chained from others
    std::int64_t changed = 0;                       // the graph's version when this was first seen
  };
  struct LinkPoint {
    const graph::LinkPoint* link_point = nullptr;
    std::optional<PoseWithCovariance> T_world_place;
    std::int64_t changed = 0;
  };
  template <typename Id>
  struct Removed {
    Id id;
    std::int64_t version = 0;  // in which it was missing first
  };

  std::shared_ptr<const SiteGraph> graph;
  std::int64_t since = 0;              // changes before this version are not known
  std::vector<Map> maps;               // by id
  std::vector<LinkPoint> link_points;  // by id
  std::vector<Removed<MapId>> removed_maps;
  std::vector<Removed<LinkPointId>> removed_link_points;
  std::int64_t disconnected_maps = 0;  // that no link points join to the root

  std::int64_t version() const { return graph->graph().version(); }
  // Whether the difference to `version` can be told.
  bool KnowsChangesSince(std::int64_t version) const { return version >= since && version <= this->version(); }
};

// The view of `graph` after `before` (null: none). A graph that is older than the one before is that of another site
// with the same id: its view begins anew.
absl::StatusOr<std::shared_ptr<const GraphView>> Following(const std::shared_ptr<const GraphView>& before,
                                                           const std::shared_ptr<const SiteGraph>& graph);

}  // namespace enfilade::server
