// SPDX-License-Identifier: Apache-2.0
#include "core/survey/map_plan.h"

namespace enfilade::survey {

int RoomOnSide(const rooms::RoomPartition& partition, const graph::LinkPoint& door, const MapId& map,
               const Pose2& T_level_door) {
  constexpr double kBeside = 0.6;  // m
  if (door.direction.value().empty()) return 0;
  return partition.RoomAt(T_level_door * Eigen::Vector2d(door.direction == map ? kBeside : -kBeside, 0.0));
}

}  // namespace enfilade::survey
