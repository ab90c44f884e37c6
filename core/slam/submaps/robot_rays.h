// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/binary.h"
#include "core/geometry/pose2.h"
#include "core/grid/scan_rays.h"

namespace enfilade::slam {

// The scan's rays in the robot's frame. Coordinates are rounded to single precision (ranges are no more precise), so
// that they can be stored exactly in half the space.
grid::ScanRays RobotRays(const sensor::LaserScan& scan, const grid::ScanRayOptions& options);

// The same rays in another frame.
grid::ScanRays Transformed(const Pose2& T_target_source, const grid::ScanRays& rays);

// For checkpoints and submaps: exact for rays in single precision.
void PutRays(BinaryWriter& writer, const grid::ScanRays& rays);
grid::ScanRays GetRays(BinaryReader& reader);

}  // namespace enfilade::slam
