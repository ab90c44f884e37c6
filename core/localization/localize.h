// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/localization/localization_options.h"
#include "core/localization/pose_search.h"
#include "core/localization/query_scans.h"
#include "core/localization/searchable_map.h"

namespace enfilade::localization {

// Gives a map while it is searched, so that not all need to be in memory at once. Called twice for each map at most.
// An error ends the localisation.
using MapLoader = std::function<absl::StatusOr<std::shared_ptr<const SearchableMap>>()>;

// A map that the robot may be in.
struct CandidateMap {
  MapLoader load;
  // Where the robot is at the last scan, as far as known. Bounds the search.
  std::optional<PoseWithCovariance> T_map_robot = std::nullopt;
  // Where the map is among others, if known: poses of two maps that are the same place are no rivals.
  std::optional<Pose2> T_world_map = std::nullopt;
};

struct LocatedPose {
  std::size_t map = 0;             // index of the candidate
  PoseWithCovariance T_map_robot;  // at the last scan
  double score = 0.0;              // share of the hits, over all scans, that lie on walls
  double odds_behind = 0.0;        // log-likelihood of the best pose minus this one's
  bool confident = false;          // the first one at most
};

struct Localization {
  std::vector<LocatedPose> poses;  // the likeliest first; empty: nowhere known
  std::string reason;              // for people: why the first is certain or not, or why there is none
};

// Where in all the maps the robot is. Each place in any map where the first, a middle or the last scan fits (FindPoses)
// is followed through all scans (TrackPose) and compared beam by beam; hits in free space and beams through walls speak
// against it. The best is certain if it explains the scans well, is determined in all directions, every place that
// fits was compared, and no rival, in any map, comes near it.
//
// INVALID_ARGUMENT as SelectScans. Errors of `keep_going` and of the maps' loaders are passed on.
absl::StatusOr<Localization> Localize(const std::vector<QueryScan>& scans, const std::vector<CandidateMap>& maps,
                                      const LocalizationOptions& options, const KeepGoing& keep_going);

// The same in one map, with the default options. Scans that show no walls give no pose.
absl::StatusOr<Localization> LocalizeIn(const std::shared_ptr<const SearchableMap>& map,
                                        const std::vector<QueryScan>& scans);

}  // namespace enfilade::localization
