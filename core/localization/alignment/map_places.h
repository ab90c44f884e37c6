// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/localization/alignment/alignable_map.h"
#include "core/localization/alignment/alignment_options.h"
#include "core/localization/alignment/map_fit.h"
#include "core/localization/pose_search.h"

namespace enfilade::localization {

// A place of map b in map a where more wall matches than does not.
struct MapPlace {
  Pose2 T_a_b;
  MapFit fit;

  // m: what speaks for it, less what speaks against it, which counts twice.
  double weight() const { return fit.matched() - 2.0 * fit.contradicted(); }
};

// All places around the guess, and around the guess turned by 180 degrees, refined, each once. Errors of `keep_going`
// are passed on.
absl::StatusOr<std::vector<MapPlace>> FindMapPlaces(const AlignableMap& a, const AlignableMap& b,
                                                    const AlignmentGuess& guess, const MapAlignmentOptions& options,
                                                    const KeepGoing& keep_going);

// Whether both put `middle_b` at the same place, in the same direction.
bool IsSamePlace(const Pose2& T_a_b, const Pose2& other, const Eigen::Vector2d& middle_b,
                 const MapAlignmentOptions& options);

// m; `points` is not empty.
Eigen::Vector2d MeanOf(const std::vector<Eigen::Vector2d>& points);
// The middle of what is known of the walls.
Eigen::Vector2d MiddleOfSurfaces(const AlignableMap& map);

}  // namespace enfilade::localization
