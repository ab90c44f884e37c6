// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/grid/scan_rays.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/matching/local_matching.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/existing_map.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {

// Where a scan was taken.
struct LocatedScan {
  Track track;                                                // after the scan
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  // of track.T_submap_robot
  double matched_share = 0.0;                                 // share of the scan's hits, 0..1
  std::optional<double> residual;                             // m, of a good match (MatchResult::residual)
  bool may_insert = true;                                     // false: the scan contradicts the submap
};

// The first scan is taken at the active submap's origin, by definition.
LocatedScan LocateFirstScan(const sensor::PairedScan& scan);

// Predicts the motion since `last`, matches the scan to the active submap, and judges the match. If the odometry's
// prediction leads to no match, matches without odometry: wheels slip, and odometry jumps. `rays`: the scan's, in the
// robot's frame.
LocatedScan LocateScan(const Track& last, const sensor::PairedScan& scan, const grid::ScanRays& rays,
                       const LocalMap& map, const SlamOptions& options);

// The pose of the first scan in an existing map: by matching it to what was seen at the entry, or by the odometry since
// (PoseAtScan).
PoseWithCovariance LocateAtEntry(const ExistingMapEntry& entry, const sensor::PairedScan& scan,
                                 const grid::ScanRays& rays, const SlamOptions& options);

}  // namespace enfilade::slam
