// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace enfilade::storage::postgres {

// A polygon without holes as well-known binary (OGC 06-103r4, 8.2), little-endian; `corners` without the repeated last
// one. Empty bytes for no corners.
std::string EncodePolygon(const std::vector<Eigen::Vector2d>& corners);

// The outer ring of what EncodePolygon wrote, and of whatever PostGIS' ST_AsBinary(polygon, 'NDR') gives. DATA_LOSS on
// other bytes.
absl::StatusOr<std::vector<Eigen::Vector2d>> DecodePolygon(std::string_view bytes);

}  // namespace enfilade::storage::postgres
