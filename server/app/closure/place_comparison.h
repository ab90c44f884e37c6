// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "core/closure/judge_passage.h"
#include "perception/cloud/cloud.h"
#include "perception/image/features.h"
#include "server/app/closure/stored_views.h"
#include "storage/link_point_store.h"

namespace enfilade::server {

// What the robot sees behind the door that it has passed. The views are StoredViews'.
struct ViewsBehind {
  // The last moments, the nearest to the report first; empty: no images.
  std::vector<const perception::FeatureSet*> ahead;  // from the door into the map: the front camera
  std::vector<const perception::FeatureSet*> back;   // back at the door: the rear camera
  const perception::Cloud* cloud = nullptr;          // null: none
  Pose2 T_cloud_robot;  // from where the cloud was taken to where the robot is when it reports
  double beyond = 1.0;  // m that the cloud was taken behind the door
};

// A place, as the map behind it saw it.
struct Place {
  const graph::LinkPoint* link_point = nullptr;
  const graph::Anchor* anchor = nullptr;        // in the map behind
  std::vector<storage::Evidence> evidence;      // of that anchor
  std::optional<double> distance;               // as PlaceEvidence
  std::optional<PoseWithCovariance> predicted;  // T_map_robot where the robot reports, by the graph
};

// The first half of a PlaceEvidence, by images: who has come out of a door looks away from it, so that the front camera
// is compared with what looked into the map then (the rear camera of a robot that faced the door); without those, the
// rear camera with what looked at the door. Errors are the stores'.
absl::StatusOr<closure::PlaceEvidence> CompareImages(const storage::CallContext& context, const Place& place,
                                                     const ViewsBehind& behind,
                                                     const closure::DoorClosureOptions& options, StoredViews& views);
// The second half, by clouds: registered from the graph's prediction and from before the door; the best is taken.
absl::Status CompareClouds(const storage::CallContext& context, const Place& place, const ViewsBehind& behind,
                           const closure::DoorClosureOptions& options, StoredViews& views,
                           closure::PlaceEvidence& evidence);

}  // namespace enfilade::server
