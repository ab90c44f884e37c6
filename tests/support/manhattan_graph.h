// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/optimize/pose_graph.h"

namespace enfilade::testing {

// A robot drives through a grid of streets with edges of 1 m, turns left or right at random corners, and closes loops
// when it is within 1.5 m of an earlier pose.
struct ManhattanOptions {
  int nodes = 400;
  int streets = 12;  // the world is streets x streets corners
  // Of the measurements' error, in the measurement's frame: correlated, so that the information is a full matrix.
  double sigma_xy = 0.03;    // m
  double sigma_yaw = 0.015;  // rad
  double loops_per_node = 0.6;
  double outlier_share = 0.0;  // of the loop edges: joins two random nodes by a random pose
  std::uint32_t seed = 1;
};

struct ManhattanGraph {
  optimize::PoseGraph graph;     // node i has id i; posed by odometry; odometry edges are not robust, loop edges are
  std::vector<Pose2> truth;      // per node
  std::vector<char> is_outlier;  // per edge
};

ManhattanGraph MakeManhattanGraph(const ManhattanOptions& options);

// The root mean square distance of the nodes from the truth, m.
double RootMeanSquareError(const optimize::PoseGraph& graph, const std::vector<Pose2>& truth);

}  // namespace enfilade::testing
