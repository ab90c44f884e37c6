// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::prior {

// A stretch of a drive that is taken to be rigid: some keyframes of one submap.
struct MapPiece {
  MapId id;                         // "piece-17"
  std::vector<std::int64_t> nodes;  // keyframes, in order
  std::vector<Pose2> T_piece_node;  // of each; the first is the identity
  Pose2 T_map_piece;                // by SLAM
  slam::SubmapGrid grid;            // of these keyframes' scans, in the piece's frame
  MapEvidence evidence;             // of the grid
};

// What SLAM has measured of one piece's place in another.
struct PieceLink {
  std::size_t from = 0;
  std::size_t to = 0;
  Pose2 T_from_to;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // in (x, y, yaw) of T_from_to
  bool is_closure = false;                               // otherwise `to` follows `from`
};

struct CutMap {
  std::vector<MapPiece> pieces;
  std::vector<PieceLink> links;  // from each piece to the next, and the accepted loop closures
};

// Cuts a map into pieces of about 4 m. `scans`: those that it was made of. DATA_LOSS: a submap is damaged.
absl::StatusOr<CutMap> CutIntoPieces(const slam::SlamMap& map, const std::vector<sensor::PairedScan>& scans,
                                     const slam::SlamOptions& options);

// The map with the pieces elsewhere.
slam::SlamMap WithPieces(slam::SlamMap map, const std::vector<MapPiece>& pieces,
                         const std::vector<Pose2>& T_map_pieces);
grid::OccupancyGrid RenderPieces(const std::vector<MapPiece>& pieces, const std::vector<Pose2>& T_map_pieces,
                                 const slam::SlamOptions& options);

}  // namespace enfilade::prior
