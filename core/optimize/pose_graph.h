// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"

namespace enfilade::optimize {

// One pose to be estimated.
struct PoseGraphNode {
  std::int64_t id = 0;  // unique in its graph; need not be contiguous
  Pose2 T_world_node;   // the initial guess; after solving, the estimate
};

// One relative measurement between two nodes. The residual is the SE(2) error in the measurement's frame,
//   e = [R_m^T (R_i^T (t_j - t_i) - t_m); wrap(yaw_j - yaw_i - yaw_m)],   chi2 = e^T Omega e
// (Kuemmerle et al. 2011, g2o, section III-C), m, m, rad.
struct PoseGraphEdge {
  std::int64_t from = 0;
  std::int64_t to = 0;
  Pose2 T_from_to;                                            // measured
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  // full, symmetric, positive definite
  bool robust = true;                                         // the kernel of the options applies
  bool enabled = true;  // false: kept in the graph but ignored, such as a rejected loop closure
};

struct PoseGraph {
  std::vector<PoseGraphNode> nodes;
  std::vector<PoseGraphEdge> edges;
};

}  // namespace enfilade::optimize
