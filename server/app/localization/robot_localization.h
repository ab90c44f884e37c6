// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/localization/localize.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/localization/place_ranking.h"
#include "server/app/localization/searchable_maps.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// What is known about where the robot is. All that is set must hold.
struct LocalizationPrior {
  std::optional<MapId> map;
  std::optional<PoseWithCovariance>
      T_map_robot;  // in `map`, at the last scan; then maps joined to it are searched, too
  std::optional<int> level;
};

struct LocalizationQuery {
  std::vector<localization::QueryScan> scans;
  std::optional<QueryImage> image;
  LocalizationPrior prior;
};

struct RobotPoseInMap {
  MapId map;
  PoseWithCovariance T_map_robot;
  std::optional<PoseWithCovariance> T_world_robot;  // unset: no link points join the map to the root
  double score = 0.0;                               // these as in localization::LocatedPose
  double odds_behind = 0.0;
  bool confident = false;
};

struct LocalizationAnswer {
  std::vector<RobotPoseInMap> poses;  // by the scans, the likeliest first
  std::vector<RankedPlace> places;    // by the image, the best first
  std::string reason;
  int maps_searched = 0;
  std::int64_t graph_version = 0;
};

// Finds robots in the maps of their site, by the newest revisions. Thread-safe.
class RobotLocalization {
 public:
  // All must outlive it.
  RobotLocalization(SiteGraphs& graphs, const storage::RevisionStore& revisions, const PlaceRankingStores& images)
      : graphs_(graphs), revisions_(revisions), places_(images), maps_({images.blobs, revisions}, kMaxBytes) {}

  // INVALID_ARGUMENT: neither scans nor an image; a prior's pose without a map; as localization::Localize.
  // NOT_FOUND: the site, the prior's map. RESOURCE_EXHAUSTED: kMaxSearches calls are searching already. CANCELLED and
  // DEADLINE_EXCEEDED soon after the call is.
  absl::StatusOr<LocalizationAnswer> Localize(const storage::CallContext& context, const SiteId& site,
                                              const LocalizationQuery& query);

 private:
  static constexpr std::size_t kMaxBytes = std::size_t{256} << 20;
  // A search keeps a thread of the calls busy for up to seconds.
  static constexpr int kMaxSearches = 2;

  // A map to search, and its newest revision.
  struct Candidate {
    storage::MapRevision revision;
    std::optional<PoseWithCovariance> T_map_robot;
  };
  absl::StatusOr<std::vector<Candidate>> FindCandidates(const storage::CallContext& context, const SiteId& site,
                                                        const graph::GraphSnapshot& graph,
                                                        const LocalizationPrior& prior) const;
  absl::Status LocateScans(const storage::CallContext& context, const SiteId& site, const SiteGraph& graph,
                           const LocalizationQuery& query, LocalizationAnswer& answer);

  SiteGraphs& graphs_;
  const storage::RevisionStore& revisions_;
  const PlaceRanking places_;
  SearchableMaps maps_;
  std::atomic<int> searches_{0};
};

}  // namespace enfilade::server
