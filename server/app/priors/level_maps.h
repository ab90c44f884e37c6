// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/graph/plans/plan_ties.h"
#include "core/grid/occupancy_grid.h"
#include "core/prior/alignment/map_evidence.h"
#include "server/app/graph/site_graph.h"

namespace enfilade::server {

// A map of a plan's level that has walls.
struct LevelMap {
  MapId id;
  Pose2 T_world_map;  // of LevelMaps::maps only
  grid::OccupancyGrid grid;
  prior::MapEvidence evidence;
  TimeNs create_time = 0;
};

// What robots have seen of a plan's level.
struct LevelMaps {
  std::vector<LevelMap> maps = {};      // that have a place in the world, by id
  std::vector<LevelMap> unjoined = {};  // the others, those with the most walls first
  // No map of the level is joined to the root map: `maps` lie in the frame of one of them instead of the world's.
  bool is_apart = false;
  std::shared_ptr<const SiteGraph> graph = {};
  std::shared_ptr<const graph::PlanTies> ties = {};  // of the plan that is aligned, if it was before; else null
};

}  // namespace enfilade::server
