// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/grid/files/rgb_image.h"
#include "core/grid/occupancy_grid.h"
#include "core/rooms/room_partition.h"

namespace enfilade::cli {

// A grey PNG with each cell's room: 8 bits, or 16 if there are more than 255 rooms.
absl::StatusOr<std::string> EncodeLabels(const rooms::RoomPartition& partition);

// The map with its rooms in colours and its doors as red lines.
grid::RgbImage DrawRooms(const grid::OccupancyGrid& grid, const rooms::RoomPartition& partition);

}  // namespace enfilade::cli
