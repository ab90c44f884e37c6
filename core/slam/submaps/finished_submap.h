// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/submap.h"

namespace enfilade::slam {

// A submap that gets no more scans: its content compressed, and uncompressed what the pose graph needs of it.
struct FinishedSubmap {
  Pose2 T_map_submap;
  std::int64_t version = 0;
  std::string content;  // Encode(SubmapContent)
  // Those of the content; of a submap that SessionChain has joined to others, by its numbers.
  std::vector<SubmapNode> nodes;
  std::optional<NextSubmap> next;
  double length = 0.0;  // m driven in it
  double extent = 0.0;  // m, from its origin to its farthest keyframe
  // Only of an existing map, which has no keyframes: the bounding box of its known cells, m. Otherwise empty.
  Eigen::AlignedBox2d known;
};

FinishedSubmap FinishSubmap(const Pose2& T_map_submap, std::int64_t version, std::string content,
                            const std::vector<SubmapNode>& nodes, const std::optional<NextSubmap>& next);

// The existing map as submap 0. `content.next` is set by the first scan.
FinishedSubmap FinishExistingMap(std::int64_t version, const SubmapContent& content);

// From a stored row. DATA_LOSS if its content is damaged.
absl::StatusOr<FinishedSubmap> RestoreFinishedSubmap(const SlamSubmap& row, const OccupancyOptions& options);

}  // namespace enfilade::slam
