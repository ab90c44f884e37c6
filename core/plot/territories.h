// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/plot/scene.h"

namespace enfilade::plot {

// A raster, and where robots drove while they mapped it (m, the scene's frame).
struct DrivenRaster {
  SceneRaster raster;
  std::vector<Eigen::Vector2d> drives;
  int level = 0;  // maps above each other take no place from one another
};

// What robots see of a room through its door is in the neighbour's map, too. Gives each place of a level to one raster:
// to the one whose drives are nearest over ground that this raster knows to be free (multi-source Dijkstra), but not
// through `doors` (m, the scene's frame) unless nothing else leads there; walls to that of the ground beside them.
// Cells elsewhere become unknown. Places that no drive reaches stay in every raster that knows them, as do all cells if
// there are no drives.
std::vector<SceneRaster> CutToTerritories(std::vector<DrivenRaster> rasters, const std::vector<Eigen::Vector2d>& doors);

}  // namespace enfilade::plot
