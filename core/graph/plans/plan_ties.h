// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"

namespace enfilade::graph {

// A straight piece between two corners of a plan. Most are walls. Doors, and the shortest ways between parts that no
// wall joins, hold a plan together too.
struct PlanStrut {
  int from = 0;   // index of a corner
  int to = 0;     // ... of another
  int wall = -1;  // its number in the plan; -1: it is none

  friend bool operator==(const PlanStrut&, const PlanStrut&) = default;
};

// A wall of a plan as a straight line in a map: its centre line, whichever face has been seen.
struct WallSighting {
  int strut = 0;  // index
  MapId map = {};
  // The middle of the stretch that was seen, m and rad in the map's frame; x points from the strut's first corner to
  // its second. Its x is not measured: nobody sees where along a wall he is.
  Pose2 T_map_line = {};
  double along = 0.0;         // m, from the strut's middle to there, as the plan has it
  double length = 0.0;        // m, of what was seen
  double across_sigma = 0.0;  // m
  double yaw_sigma = 0.0;     // rad

  friend bool operator==(const WallSighting&, const WallSighting&) = default;
};

// A lift or a staircase of a plan, as it is drawn.
struct ShaftInPlan {
  std::string name = {};
  bool is_lift = true;
  std::vector<Eigen::Vector2d> outline = {};  // m, in the plan's frame, counter-clockwise
  std::vector<int> held_by = {};              // of each of its corners, the index of a corner of the plan near it

  Eigen::Vector2d middle() const;  // of its corners

  friend bool operator==(const ShaftInPlan&, const ShaftInPlan&) = default;
};

// Where a map lay in the plan when its walls were recognised.
struct MapInPlan {
  MapId map = {};
  Pose2 T_plan_map = {};

  friend bool operator==(const MapInPlan&, const MapInPlan&) = default;
};

// What ties maps to one another by a floor plan: the walls of it that robots have seen, in each of the maps. The plan's
// frame has metres, and is that of the world when the plan was placed as a whole.
struct PlanTies {
  std::vector<Eigen::Vector2d> corners;  // m
  std::vector<PlanStrut> struts;
  std::vector<WallSighting> sightings;
  std::vector<MapInPlan> maps;           // by id; of all sightings
  std::vector<ShaftInPlan> shafts = {};  // those with a name
  // How wrong the plan is: each corner by itself (m), and the length of each strut relative to it.
  double corner_sigma = 0.1;
  double stretch_sigma = 0.04;

  // Whether walls of the plan were seen in the map.
  bool HasSeen(const MapId& map) const;
  // Drops what was seen in other maps than these.
  void KeepMaps(const std::vector<MapId>& kept);

  friend bool operator==(const PlanTies&, const PlanTies&) = default;
};

// A plan as part of a site's graph.
struct PlanInGraph {
  PriorMapId id = {};
  std::string sha256 = {};  // of its encoded ties, with all maps; equal digests and maps have equal ties
  std::shared_ptr<const PlanTies> ties = {};
  int level = 0;  // the floor that it is of

  friend bool operator==(const PlanInGraph& a, const PlanInGraph& b) {
    if (a.id != b.id || a.sha256 != b.sha256 || a.level != b.level) return false;
    return a.ties == b.ties || (a.ties && b.ties && a.ties->maps == b.ties->maps);
  }
};

// The form in which ties are stored. Little-endian; a byte of format version first: 1, or 2 if there are shafts.
std::string EncodePlanTies(const PlanTies& ties);
// DATA_LOSS: damaged bytes, an index out of range, a number that is not finite, a sigma that is not positive, a
// sighting in a map that is not listed, a shaft without name or of fewer than three corners. FAILED_PRECONDITION: a
// newer format version.
absl::StatusOr<PlanTies> DecodePlanTies(std::string_view bytes);

}  // namespace enfilade::graph
