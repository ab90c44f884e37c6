// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/graph/link_point.h"

namespace enfilade::graph {

// Two estimates of one place may always lie this far apart, m: half a narrow door.
constexpr double kMinSamePlaceDistance = 0.3;

// How far apart two estimates of one place may lie, m: the radius of the 95 % circle of their difference, sqrt(5.991
// lambda_max), lambda_max the larger eigenvalue of the summed position covariances; at least kMinSamePlaceDistance.
// migrations/deploy/link_points.sql has the same formula as a last line of defence; a contract test compares them.
double SamePlaceDistance(const Eigen::Matrix3d& covariance_a, const Eigen::Matrix3d& covariance_b);

// The place that two link points have in common.
struct CommonPlace {
  int map_count = 0;      // maps in which both have an anchor: at least 2
  double distance = 0.0;  // the largest between their anchors in one map, m
};

// Set if one link point makes the other redundant: at least two maps have an anchor of each, and in every such map the
// two anchors are within SamePlaceDistance.
std::optional<CommonPlace> FindCommonPlace(const std::vector<Anchor>& a, const std::vector<Anchor>& b);

}  // namespace enfilade::graph
