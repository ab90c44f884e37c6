// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>
#include <string>
#include <vector>

#include "core/graph/graph_snapshot.h"
#include "fmt/format.h"

namespace enfilade::testing {

// "m", 3 -> "m3".
template <typename Number>
std::string Numbered(const char* prefix, Number number) {
  return fmt::format("{}{}", prefix, number);
}
MapId M(const std::string& id);
LinkPointId L(const std::string& id);
graph::MapInGraph MapNamed(const std::string& id, int level = 0);
graph::Anchor AnchorIn(const std::string& map, const Pose2& T_map_place,
                       const Eigen::Matrix3d& covariance = graph::DefaultAnchorCovariance());
graph::LinkPoint Joining(const std::string& id, std::vector<graph::Anchor> anchors);

// `snapshot`, or nothing, with these.
graph::GraphSnapshot Graph(const std::vector<std::string>& maps, const std::vector<graph::LinkPoint>& link_points,
                           const graph::GraphSnapshot& snapshot = {});

// A pose drawn from N(mean, covariance), componentwise.
Pose2 Draw(const PoseWithCovariance& pose, std::mt19937_64& random);
// A covariance of full rank with correlations; the deviations lie between 0.5 and 1.5 times those given (m, rad).
Eigen::Matrix3d RandomCovariance(double position, double yaw, std::mt19937_64& random);
double Uniform(double low, double high, std::mt19937_64& random);

// The truth: where the maps and places lie in the world. What robots see of it is drawn with noise.
struct World {
  std::vector<Pose2> T_world_maps;  // of maps "m0", "m1", ...; the first at the origin

  // The place as the maps see it, each anchor with noise drawn from its covariance.
  graph::LinkPoint See(const std::string& id, const Pose2& T_world_place, const std::vector<int>& maps,
                       const std::vector<Eigen::Matrix3d>& covariances, std::mt19937_64& random) const;
  std::vector<std::string> MapIds() const;
};
// Maps strewn over a square of `size_m`.
World RandomWorld(int maps, double size_m, std::mt19937_64& random);

}  // namespace enfilade::testing
