// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/sdk/api/world_trajectory.h"
#include "client/sdk/connection.h"
#include "core/geometry/pose2.h"

namespace enfilade::testing {

struct MappedLinkPoint {
  std::string id;
  std::vector<std::string> maps;  // in which it has an anchor
  bool joins = false;
  std::optional<Eigen::Vector2d> world;  // its place
};

// One map in another, along the chain of `hops` link points.
struct MapTransform {
  std::string a;
  std::string b;
  int hops = 0;
  PoseWithCovariance T_a_b;
};

// What the server knows about a site: its graph, and where it has mapped each robot.
struct MappedState {
  std::vector<std::string> maps;
  std::string root;                                 // the map whose frame is the world's
  std::map<std::string, PoseWithCovariance> poses;  // T_world_map, of maps that are joined to the root
  std::vector<MapTransform> transforms;             // of maps that a link point joins, and of all maps in the root
  std::vector<MappedLinkPoint> link_points;
  std::map<std::string, std::vector<client::MappedStretch>> stretches;  // by robot

  int candidates() const;
  // Pieces of the graph: maps that link points join are in one piece.
  int components() const;
};

// Waits until every session of the site is mapped (or has failed) and the graph no longer changes, and reads the state.
// Throws if that takes longer than it ever should, or a call fails.
MappedState ReadWhenQuiet(const client::Connection& connection, const std::string& site,
                          const std::vector<std::string>& robots);

}  // namespace enfilade::testing
