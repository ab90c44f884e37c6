// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"
#include "core/rooms/room_partition.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/slam_profiles.h"
#include "core/survey/level_survey.h"
#include "server/app/graph/site_graph.h"
#include "server/app/survey/drive_cache.h"
#include "server/app/survey/drive_reader.h"
#include "storage/maps/map_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

struct SurveyMappingOptions {
  sensor::ScanPairingOptions pairing;
  slam::SlamProfiles slam;
};

// One level, mapped as a whole: each drive from end to end, through all doors, with SLAM's own loop closures. The first
// drive's start is the level's origin; later drives continue the map of those before them, where the graph joins them,
// or else where their scans show (DriveLocation).
struct MappedLevel {
  survey::LevelSurvey survey;
  grid::OccupancyGrid grid;  // in the level's frame
  // What robots know of its rooms, in that frame, drive after drive.
  std::vector<Eigen::Vector2d> trajectory;   // where they were at each scan, m
  std::vector<rooms::PassageHint> passages;  // the doors that they have reported to have gone through
};

struct SiteSurvey {
  std::vector<MappedLevel> levels;
  std::vector<SessionId> sessions;  // that it contains
  std::int64_t graph_version = 0;   // that it was made at
};

struct SurveyRun {
  // Of drives that it has only what is new is mapped; afterwards it has those of this survey.
  DriveCache& cache;
  // A drive begins in the map of those before it. If these have gone on since, it is mapped again in what they are now,
  // or else continued in what they were, which is faster. It is always continued while a robot is recording.
  bool continue_drives = false;
  // Asked between portions; its error ends the survey.
  const std::function<absl::Status()>& proceed;
};

// Reads and maps all that is mapped of a site. Sessions whose records retention has deleted, and drives that neither
// the graph nor their scans join to the others, are left out.
absl::StatusOr<SiteSurvey> MapSite(const SurveyStores& stores, const SurveyMappingOptions& options,
                                   const SiteGraph& graph, const SiteId& site, const SurveyRun& run);

}  // namespace enfilade::server
