// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/sensor/record.h"
#include "perception/image/features.h"
#include "storage/graph/link_point_store.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/feature_store.h"

namespace enfilade::server {

struct QueryImage {
  sensor::Camera camera = sensor::Camera::kFront;
  std::string content;  // a PNG or JPEG file
};

// A place whose kept image resembles the robot's.
struct RankedPlace {
  LinkPointId link_point;
  MapId map;
  // Where the robot stood, facing as the robot does now; unset: unknown.
  std::optional<Pose2> T_map_view;
  int matches = 0;  // verified
  bool accepted = false;
};

struct PlaceRankingStores {
  const storage::LinkPointReader& link_points;
  const storage::BlobStore& blobs;
  const storage::FeatureStore& features;
};

// Which places to compare: with an anchor in `map` (or also in others, with joined_maps) and on `level`.
struct PlaceFilter {
  std::optional<MapId> map;
  std::optional<int> level;
  bool joined_maps = false;
};

// Ranks the places with kept images by how well these match an image of the robot. Thread-safe.
class PlaceRanking {
 public:
  // All must outlive it.
  explicit PlaceRanking(const PlaceRankingStores& stores) : stores_(stores) {}

  // The best first, each place and map once; those without a verified match are left out. INVALID_ARGUMENT: the image
  // cannot be decoded or shows nothing. CANCELLED, DEADLINE_EXCEEDED; errors of the stores.
  absl::StatusOr<std::vector<RankedPlace>> Rank(const storage::CallContext& context, const SiteId& site,
                                                const graph::GraphSnapshot& graph, const PlaceFilter& filter,
                                                const QueryImage& image) const;

 private:
  absl::StatusOr<std::optional<perception::FeatureSet>> FeaturesOf(const storage::CallContext& context,
                                                                   const SiteId& site,
                                                                   const sensor::BlobRef& image) const;

  const PlaceRankingStores stores_;
};

}  // namespace enfilade::server
