// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/localization/alignment/alignable_map.h"
#include "core/localization/alignment/alignment_options.h"
#include "core/localization/pose_search.h"

namespace enfilade::localization {

struct MapAlignment {
  bool accepted = false;
  std::string reason;                       // for people: why it is not, or what it rests on
  std::optional<PoseWithCovariance> T_a_b;  // the best place; unset: they nowhere fit
  double score = 0.0;                       // of the surfaces of b that a knows, the share on walls of a
  double overlap = 0.0;                     // m^2 of ground that both have seen free
  double rival_ratio = 0.0;                 // how many times as well it fits as the best other place; 0: there is none
  Eigen::Vector2d place_a = Eigen::Vector2d::Zero();  // m: in the middle of the overlap
};

// Where map b lies in map a by the walls that both have seen. All places around the guess, and around the guess turned
// by 180 degrees, where enough walls of one lie on walls of the other (FindPoses) are refined (slam::MatchToField) and
// compared both ways: walls on walls, seen from the same side, speak for a place, walls on free ground against it. The
// best is accepted if it is determined in all directions and no other place explains the maps nearly as well, be it far
// away, turned, or a little farther along the corridor. Maps of identical corridors are thus ambiguous.
//
// INVALID_ARGUMENT: a guess that is out of range. Errors of `keep_going` are passed on.
absl::StatusOr<MapAlignment> AlignMaps(const AlignableMap& a, const AlignableMap& b, const AlignmentGuess& guess,
                                       const MapAlignmentOptions& options, const KeepGoing& keep_going);

}  // namespace enfilade::localization
