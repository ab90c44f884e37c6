// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "core/closure/closure_options.h"
#include "core/closure/door_knowledge.h"
#include "perception/cloud/cloud.h"
#include "perception/image/features.h"
#include "perception/image/match_images.h"
#include "server/app/closure/stored_views.h"
#include "storage/graph/link_point_store.h"

namespace enfilade::server {

// How images of doors are matched.
perception::ImageMatchOptions ImageMatchOptionsOf(const closure::DoorClosureOptions& options);

// What the robot saw behind the door that it passed. Images and cloud are StoredViews'.
struct RobotViews {
  // The last ones, the nearest to the report first; empty: no images.
  std::vector<const perception::FeatureSet*> ahead;  // from the door into the map: the front camera
  std::vector<const perception::FeatureSet*> back;   // back at the door: the rear camera
  const perception::Cloud* cloud = nullptr;          // null: none
  Pose2 T_cloud_robot;       // from where the cloud was taken to where the robot is when it reports
  double beyond_door = 1.0;  // m: how far behind the door the cloud was taken
};

// Compares what the robot saw behind a door with what is kept of a place, and adds the results to the place.
class PlaceComparer {
 public:
  // All must outlive it.
  PlaceComparer(const RobotViews& robot, const closure::DoorClosureOptions& options, StoredViews& views)
      : robot_(robot), options_(options), views_(views) {}

  // A robot that has come through a door looks away from it. So its front camera is compared with kept images that look
  // into the map (the rear camera of a robot that faced the door); without those, its rear camera with kept images that
  // look at the door. `kept`: the evidence of the place's anchor. Errors are the stores'.
  absl::Status CompareImages(const std::vector<storage::Evidence>& kept, closure::ComparedPlace& place) const;
  // Registers the clouds from the graph's prediction and, unless that is sure, from in front of the door; the best
  // registration counts.
  absl::Status CompareClouds(const std::vector<storage::Evidence>& kept, closure::ComparedPlace& place) const;

 private:
  absl::StatusOr<std::vector<const perception::FeatureSet*>> FindKeptImages(const std::vector<storage::Evidence>& kept,
                                                                            const closure::ComparedPlace& place,
                                                                            bool away) const;
  absl::StatusOr<closure::ImageComparison> MatchImages(const std::vector<const perception::FeatureSet*>& kept,
                                                       const std::vector<const perception::FeatureSet*>& now) const;
  std::vector<Pose2> InitialGuesses(const closure::ComparedPlace& place, const Pose2& T_map_evidence) const;

  const RobotViews& robot_;
  const closure::DoorClosureOptions& options_;
  StoredViews& views_;
};

}  // namespace enfilade::server
