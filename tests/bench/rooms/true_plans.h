// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::bench {

// A map whose rooms are known.
struct TruePlan {
  std::string name;
  grid::OccupancyGrid map;
  std::vector<int> rooms;  // of each cell, from 1; 0: none
};

// NAME`kind`.png of a folder with the truth NAME_gt_segmentation.png, in which each door is closed by a line.
absl::StatusOr<std::vector<TruePlan>> ReadTruePlans(const std::filesystem::path& folder, const std::string& kind);

// gt_colored_NAME.png: the free ground of a robot's map, each room in a colour of its own; black is all else, and lines
// one pixel wide that close the doors. The plan is named robot:NAME.
// If incremental_NAME.png lies beside it, that is the map: the truth is turned by 20 degrees (M. Luperto et al.,
// declutter-reconstruct). Otherwise the map is made from the truth: black up to 0.15 m from free ground is wall,
// what is farther was not seen, and doors are opened again. A door is a stretch of 0.5 to 2.5 m between two rooms where
// the black is one pixel thick; longer ones are thin walls, as far as the picture tells.
absl::StatusOr<TruePlan> ReadColouredPlan(const std::filesystem::path& truth);

}  // namespace enfilade::bench
