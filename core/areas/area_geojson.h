// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/areas/map_area.h"
#include "core/base/ids.h"

namespace enfilade::areas {

struct NamedArea {
  MapAreaId id;  // empty: it has none yet
  MapArea area;
};

// A GeoJSON FeatureCollection (RFC 7946) in metres of the map's frame, as the member "frame": "map_metres" says. Each
// area is a Polygon, counter-clockwise, with the member "id": "areas/<id>" and the properties "kind" (NameOfKind),
// "name", "robot_types" (a list), "speed_limit_mps" (a number; speed limits only), "valid_from" and "valid_until" (RFC
// 3339 in UTC; left out if unset).
std::string WriteAreasGeoJson(const std::vector<NamedArea>& areas);

// Reads what WriteAreasGeoJson writes, exactly, but that outlines may begin at another corner; and other GeoJSON in
// metres whose features have these properties. "kind" is needed; "name" is the kind if missing; unknown properties are
// ignored. INVALID_ARGUMENT naming the feature (from 0) and its fault: no GeoJSON; another frame; a geometry that is
// not a Polygon of one ring, a property of another type, an area that is not valid (Validate); more than 10,000
// features.
absl::StatusOr<std::vector<NamedArea>> ReadAreasGeoJson(std::string_view text);

}  // namespace enfilade::areas
