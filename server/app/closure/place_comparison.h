#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "core/closure/judge_passage.h"
#include "perception/cloud/cloud.h"
#include "perception/image/match_series.h"
#include "server/app/closure/stored_views.h"
#include "storage/link_point_store.h"

namespace enfilade::server {

// What the robot sees behind the door that it has passed. The views are StoredViews'.
struct ViewsBehind {
  std::vector<perception::Views> series;     // moments; empty: no images
  const perception::Cloud* cloud = nullptr;  // null: none
  Pose2 T_cloud_robot;                       // from where the cloud was taken to where the robot is when it reports
  double beyond = 1.0;                       // m that the cloud was taken behind the door
};

// A place, as the map behind it saw it.
struct Place {
  const LinkPoint* link_point = nullptr;
  const Anchor* anchor = nullptr;               // in the map behind
  std::vector<Evidence> evidence;               // of that anchor
  std::optional<double> distance;               // as PlaceEvidence
  std::optional<PoseWithCovariance> predicted;  // T_map_robot where the robot reports, by the graph
};

// The first half of a PlaceEvidence, by images. Errors are the stores'.
absl::StatusOr<PlaceEvidence> CompareImages(const CallContext& context, const Place& place, const ViewsBehind& behind,
                                            const ClosureOptions& options, StoredViews& views);
// The second half, by clouds: registered from the graph's prediction and from before the door; the best is taken.
absl::Status CompareClouds(const CallContext& context, const Place& place, const ViewsBehind& behind,
                           const ClosureOptions& options, StoredViews& views, PlaceEvidence& evidence);

}  // namespace enfilade::server
