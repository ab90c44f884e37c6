// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace enfilade::survey {

struct SurveyOptions {
  double reach = 0.5;  // m: a robot was in a room if it came this far from the place where it entered it
  double snap = 0.4;   // m: a pose in no room belongs to a room this near
  // m: a link point this near to a door is that door's.
  double same_door = 1.0;
  // A session stays where it is in its map if that is within this much of where the survey has it.
  double apart = 0.1;    // m
  double turned = 0.04;  // rad
  // A link point's anchors stay as they are if their standard deviations are those of new ones, but for this factor.
  double as_sure = 1.3;
  // Of a door's anchor, times the square root of the drives' variance factor: of the door itself, and for each metre of
  // the map's extent (MapPlan::extents), because maps are slightly bent.
  double door_sigma = 0.019;       // m
  double bend = 0.0068;            // m/m
  double door_yaw_sigma = 0.0068;  // rad
  double yaw_bend = 0.00137;       // rad/m
  double ride_yaw_sigma = 0.012;   // rad: of how a ride shows one level's heading relative to another's
  double candidate_ahead = 3.5;    // m: a candidate was seen from up to this far before its door
  double candidate_across = 1.0;   // m
  std::string map_name = "Map";    // a new map's name is this and the least free number
};

}  // namespace enfilade::survey
