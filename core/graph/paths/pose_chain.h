// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/link_point.h"
#include "core/graph/paths/shortest_paths.h"

namespace enfilade::graph {

// T_from_to across a link point: A * B^-1, with the covariances of both anchors (map_manager: A in map `from`, B in
// `to`).
PoseWithCovariance TransformAcross(const Anchor& from, const Anchor& to);

// One link point passed by a chain of poses.
struct PoseHop {
  LinkPointId link_point;
  MapId from;
  MapId to;
  PoseWithCovariance T_from_to = {};
  // The share of the result's covariance due to this hop: J S J' with J = d result / d T_from_to. The shares of a
  // chain's parts add up to its covariance, all to first order.
  Eigen::Matrix3d share = Eigen::Matrix3d::Zero();
};

// T_start_end = start * hops * end, all independent of each other.
struct PoseChain {
  PoseWithCovariance T_start_end;
  Eigen::Matrix3d start_share = Eigen::Matrix3d::Zero();
  std::vector<PoseHop> hops = {};
  Eigen::Matrix3d end_share = Eigen::Matrix3d::Zero();
};

// Along `path`, from the frame of `T_start_map`, with map the path's first, to that of `T_map_end` with map its last.
PoseChain ChainAlong(const GraphSnapshot& graph, const Path& path, const PoseWithCovariance& T_start_map,
                     const PoseWithCovariance& T_map_end);

}  // namespace enfilade::graph
