// SPDX-License-Identifier: Apache-2.0
#include "core/closure/door_knowledge.h"

namespace enfilade::closure {

ComparedPlace& PlaceAt(DoorKnowledge& knowledge, const PlaceIndex& index) {
  return index.passed ? knowledge.passed->link_points[index.index].place : (*knowledge.places)[index.index];
}

void AddRide(DoorKnowledge& knowledge) {
  if (!knowledge.map) return;
  if (!knowledge.report.level_time && knowledge.entered_level() == knowledge.map->level) return;
  for (std::optional<PoseWithCovariance>* pose : {&knowledge.T_map_door, &knowledge.T_map_robot}) {
    if (*pose) (*pose)->covariance(2, 2) += knowledge.options.ride_yaw_sigma * knowledge.options.ride_yaw_sigma;
  }
}

}  // namespace enfilade::closure
