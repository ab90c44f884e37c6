// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"

namespace enfilade::prior {

// The map that SLAM makes of a log's scans.
struct MappedLog {
  slam::SlamMap map;
  grid::OccupancyGrid grid;
};

double Knob(const char* name, double value);

MappedLog MapLog(const std::vector<sensor::PairedScan>& scans, const slam::SlamOptions& options);

}  // namespace enfilade::prior
