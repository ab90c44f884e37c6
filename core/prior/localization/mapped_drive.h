// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/prior/localization/submap_tracking.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"

namespace enfilade::prior {

// The finished submaps, by id. DATA_LOSS: the content of one is damaged.
absl::StatusOr<std::vector<DriveSubmap>> SubmapsOf(const slam::SlamMap& map, const slam::SlamOptions& options);

// Adds a keyframe, in order of time, with its scan.
void AddLook(const slam::SlamNode& node, const sensor::LaserScan& scan, const slam::SlamOptions& options,
             MappedDrive& drive);

struct MappedScans {
  MappedDrive drive;
  Pose2 T_map_robot;  // at the last scan that could be used
};

// Maps a robot's scans, numbered 1, 2, ... in order of time (core/slam). INVALID_ARGUMENT: none of them could be
// mapped; keep_going's errors.
absl::StatusOr<MappedScans> MapScans(const std::vector<sensor::PairedScan>& scans, const slam::SlamOptions& options,
                                     const KeepGoing& keep_going);

}  // namespace enfilade::prior
