// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/geo/georeference.h"
#include "core/graph/global_pose.h"
#include "core/graph/paths/routes.h"

namespace enfilade::graph {

// GeoJSON (RFC 7946) FeatureCollections. With a georeference coordinates are longitude and latitude, as the RFC wants
// them; without one they are metres in the site's world frame, and the collection says so in its member "frame". Both
// have the member "graph_version". What no chain joins to the world has the geometry null, which the RFC allows.

// Maps (their outlines; without one the origin, as a point), link points and candidates (points), and the edges of the
// graph: one LineString for each pair of joining link points of a map, named by it. Features have the member "id":
// "maps/<id>", "linkPoints/<id>", "maps/<map>/edges/<a>/<b>"; properties as in the API, positions' standard deviations
// in metres.
std::string GraphToGeoJson(const WorldPoses& poses, const geo::Georeference* georeference = nullptr);

// One LineString per route and leg, with the map, length and the link point that it ends at. Where a map of the way is
// not joined to the world its legs have no geometry.
std::string RoutesToGeoJson(const Routes& routes, const WorldPoses& poses,
                            const geo::Georeference* georeference = nullptr);

}  // namespace enfilade::graph
