// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/rearrange/rearrangement.h"
#include "core/survey/drive_rooms.h"
#include "core/survey/level_survey.h"

namespace enfilade::survey {

// Which map each room gets: between the two halves of ArrangeMaps.
struct MapPlan {
  std::map<int, MapId> map_of_room = {};
  std::map<MapId, Pose2> T_level_map = {};  // of all maps, existing and new
  std::map<MapId, MapId> successors = {};   // of the maps that disappear
  // Rides that move in their cabins, by the doors that were made where they ended: T_to_from.
  std::map<LinkPointId, std::pair<MapId, Pose2>> moved_ways_out = {};
  // m: how far from its middle robots were in each map, the root mean square over their visits.
  std::map<MapId, double> extents = {};

  // The map that a map of before is now: itself, its successor.
  const MapId& NowOf(const MapId& map) const {
    const auto found = successors.find(map);
    return found == successors.end() ? map : found->second;
  }
};

// A level, its rooms, and where in them the drives were.
struct LevelInRooms {
  const LevelSurvey& survey;
  const rooms::RoomPartition& partition;
  const RoomsOfDrives& found;
};

// The room on the side of a door that `map` was on when the door was found: ahead if the door leads into the map,
// behind it otherwise. Which map each side has now does not matter: maps may have exchanged their rooms. 0: in no room.
// `T_level_door`: looks to where the door leads.
int RoomOnSide(const rooms::RoomPartition& partition, const graph::LinkPoint& door, const MapId& map,
               const Pose2& T_level_door);

// Adds link points, kept and new, and those to be removed.
void ArrangeDoors(const LevelInRooms& level, const MapPlan& plan, const SurveyOptions& options,
                  const std::function<std::string()>& new_id, rearrange::Rearrangement& result);

}  // namespace enfilade::survey
