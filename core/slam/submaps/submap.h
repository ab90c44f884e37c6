// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/grid/scan_rays.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::slam {

// A keyframe's pose in a submap, as measured when it was added. Never changes.
struct SubmapNode {
  std::int64_t node = 0;
  bool carried = false;  // copied from the previous submap
  double length = 0.0;   // m driven since the previous keyframe; more if the robot was lost in between
  Pose2 T_submap_node;
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  // of (x, y, yaw) of T_submap_node

  friend bool operator==(const SubmapNode&, const SubmapNode&) = default;
};

// The next submap's pose, as measured when it began.
struct NextSubmap {
  Pose2 T_submap_next;
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  // of (x, y, yaw) of T_submap_next

  friend bool operator==(const NextSubmap&, const NextSubmap&) = default;
};

// What a submap holds, in its own frame. `scans[i]` belongs to `nodes[i]`. A finished submap has no scans: they are in
// its grid and in the session's log.
struct SubmapContent {
  std::vector<SubmapNode> nodes;
  std::optional<NextSubmap> next;
  std::vector<grid::ScanRays> scans;  // in the robot's frame
  SubmapGrid grid;
};

struct Submap {
  std::int64_t id = 0;
  std::int64_t version = 0;
  Pose2 T_map_submap;
  SubmapContent content;

  int own_nodes() const;
  // Bytes of memory held.
  std::size_t bytes() const;
};

// For checkpoints: exact.
void Serialize(const SubmapContent& content, BinaryWriter& writer);
absl::StatusOr<SubmapContent> DeserializeSubmapContent(BinaryReader& reader, const OccupancyOptions& options);

// For rows: a finished submap, compressed, without scans and with rounded hit means (SubmapGrid::RoundMeans).
// DATA_LOSS if the bytes are damaged.
std::string Encode(const SubmapContent& content);
absl::StatusOr<SubmapContent> DecodeSubmapContent(std::string_view bytes, const OccupancyOptions& options);

}  // namespace enfilade::slam
