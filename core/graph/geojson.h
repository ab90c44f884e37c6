// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/geo/georeference.h"
#include "core/graph/global_pose.h"
#include "core/graph/paths/routes.h"

namespace enfilade::graph {

// GeoJSON (RFC 7946) FeatureCollections. With a georeference coordinates are longitude and latitude, as the RFC
// requires; without one they are metres in the site's world frame, as the member "frame" states. Both have the member
// "graph_version". Features that no chain connects to the world have a null geometry, which the RFC allows.

// Where a robot drove in a session.
struct Track {
  SessionId session;
  RobotId robot;
  MapId map;
  std::vector<Eigen::Vector2d> p_map;  // at least two
};

// Maps (outlines, or the origin as a point for maps without one), link points and candidates (points), and the edges of
// the graph: one LineString for each pair of link points of a map. Features have the member "id":
// "maps/<id>", "linkPoints/<id>", "maps/<map>/edges/<a>/<b>"; properties as in the API, positions' standard deviations
// in metres. Then the tracks, as "sessions/<id>/track".
std::string GraphToGeoJson(const WorldPoses& poses, const geo::Georeference* georeference = nullptr,
                           bool with_edges = true, const std::vector<Track>& tracks = {});

// One LineString per leg of each route, with its map, length and the link point at its end. Legs in maps that are not
// connected to the world have no geometry.
std::string RoutesToGeoJson(const Routes& routes, const WorldPoses& poses,
                            const geo::Georeference* georeference = nullptr);

}  // namespace enfilade::graph
