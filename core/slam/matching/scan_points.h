// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace enfilade::slam {

// Keeps a point if it is at least `spacing` (m) away from the one kept before it. Beams hit near walls densely;
// thinned, near walls do not outweigh far ones.
std::vector<Eigen::Vector2d> Thinned(const std::vector<Eigen::Vector2d>& points, double spacing);

// Every n-th point, n the least with which at most `count` points remain.
std::vector<Eigen::Vector2d> Subsampled(const std::vector<Eigen::Vector2d>& points, std::size_t count);

// The unit normals of the surfaces that the points of one scan are on, in the order of its beams. Zero where none is
// known: fewer than three points, less than 0.1 m, or not straight.
std::vector<Eigen::Vector2d> SurfaceNormals(const std::vector<Eigen::Vector2d>& points);

}  // namespace enfilade::slam
