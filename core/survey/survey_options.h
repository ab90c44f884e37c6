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
  double unsure = 1.5;   // and if its standard deviations are at most this many times those of a new one
  // Of the anchor of a door that a robot went through once, times the square root of the drives' variance factor. Most
  // of it is that maps are slightly bent.
  double door_sigma = 0.05;       // m
  double door_yaw_sigma = 0.016;  // rad
  double candidate_ahead = 3.5;   // m: a candidate was seen from up to this far before its door
  double candidate_across = 1.0;  // m
  std::string map_name = "Map";   // a new map's name is this and the least free number
};

}  // namespace enfilade::survey
