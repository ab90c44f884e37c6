// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/grid/scan_rays.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/mapper/mapper_state.h"
#include "core/slam/matching/local_matching.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// Where a scan was taken.
struct Place {
  Track track;
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  // of track.T_submap_robot
  double matched_share = 0.0;                                 // of the scan's hits, 0..1
  bool may_insert = true;                                     // the scan does not contradict the submap
};

// The first scan's: the active submap's origin.
Place FirstPlace(const sensor::PairedScan& scan, const MotionOptions& options);

// Predicts the motion since `last`, matches the scan to the active submap, and judges the match. Where odometry leads
// to no match the scans are asked alone: wheels slip and jump.
Place Locate(const Track& last, const sensor::PairedScan& scan, const grid::ScanRays& rays, const SubmapGrid& grid,
             const LocalFields& fields, const SlamOptions& options);

}  // namespace enfilade::slam
