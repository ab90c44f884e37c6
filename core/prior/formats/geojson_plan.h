// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// A plan as a GeoJSON (RFC 7946) FeatureCollection. Its features have the property "kind": "wall" (LineString, with
// "from" and "to": numbers of corners, "thickness", "confidence"), "door" (LineString, "confidence"), "corner" (Point),
// "room" and "shaft" (Polygon, "name"; a shaft's "shaft": "lift" or "stairs"). Coordinates are in the plan's sheet
// frame, as the member "frame": "sheet" says; "metres_per_unit" is left out if it is unknown, and
// "H_sheet_photo" (row by row) if the plan was no photo of a page. Corners are written
// first, so that corner i of the plan is the i-th feature.
std::string WriteGeoJsonPlan(const PlanGraph& plan);

// Reads what WriteGeoJsonPlan writes, exactly; and other GeoJSON: "frame": "metres" has y upwards; without the member,
// coordinates are longitude and latitude as the RFC says, and are projected about their middle. LineStrings without a
// kind are walls, as are the outlines of polygons without one; walls without "from" and "to" get corners at their ends,
// and so do those whose corners are not there: their line has been moved. A property that is null is as if left out.
// INVALID_ARGUMENT, naming the feature: no GeoJSON; a coordinate that is no number, or is beyond the range of longitude
// and latitude; an outline that crosses itself. RESOURCE_EXHAUSTED: more than kMostWalls.
absl::StatusOr<PlanGraph> ReadGeoJsonPlan(std::string_view text);

// Reads such a plan after a person has edited it. Its coordinates are the sheet's, also if a program has lost the
// member "frame"; INVALID_ARGUMENT: another frame, and as above.
absl::StatusOr<PlanGraph> ReadEditedPlan(std::string_view text);

}  // namespace enfilade::prior
