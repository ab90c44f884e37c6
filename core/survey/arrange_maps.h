// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "core/rearrange/rearrangement.h"
#include "core/rooms/room_partition.h"
#include "core/survey/level_survey.h"
#include "core/survey/survey_options.h"

namespace enfilade::survey {

// What must change so that every room that a robot has been in is one map, and every door that it went through one link
// point. `partition` is of the survey's level, in the level's frame.
//
// * A room's map is the one that robots drove farthest in, of those that no other room has; the root map and busy maps
//   come first. If there is none, a map begins.
// * Sessions move to the map of their room. One that was in several rooms is cut at each door between two maps. What
//   stays moves within its map if the survey has it elsewhere, unless the map is pinned.
// * A map without sessions leads to the map that took most of what was driven in it; an awaited one to the map of the
//   room that the robot was in.
// * Link points are the doors between the rooms that robots went through. Existing ones keep their ids. Those at no
//   such door disappear, unless they lead to a busy map or another level or are no door. Candidates move to the map
//   of the room that they were seen from, and disappear if robots went through that door, or both of its sides
//   are that room.
//
// Empty if the maps are the rooms already. The same survey gives the same answer but for the ids that `new_id` makes.
rearrange::Rearrangement ArrangeMaps(const LevelSurvey& survey, const rooms::RoomPartition& partition,
                                     const SurveyOptions& options, const std::function<std::string()>& new_id);

}  // namespace enfilade::survey
