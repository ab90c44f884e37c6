// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace enfilade::survey {

struct SurveyOptions {
  double reach = 0.5;  // m: a robot was in a room if it came this far from the place where it entered it
  double snap = 0.4;   // m: a pose in no room belongs to a room this near
  // m: a link point this near to a door is that door's.
  double same_door = 1.0;
  // A link point stays as it is if its anchors agree within this much on where the door is.
  double apart = 0.1;    // m
  double turned = 0.04;  // rad
  double as_sure = 1.3;  // and if its standard deviations are those of a new one, but for this factor
  // Of the anchor of a door that a robot went through once, times the square root of the drives' variance factor: of
  // the door itself, and for each metre of the map's extent (MapPlan::extents), because maps are slightly bent.
  double door_sigma = 0.022;      // m
  double bend = 0.008;            // m/m
  double door_yaw_sigma = 0.010;  // rad
  double yaw_bend = 0.0017;       // rad/m
  double candidate_ahead = 3.5;   // m: a candidate was seen from up to this far before its door
  double candidate_across = 1.0;  // m
  std::string map_name = "Map";   // a new map's name is this and the least free number
};

}  // namespace enfilade::survey
