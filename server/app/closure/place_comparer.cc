// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/place_comparer.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/search_radius.h"
#include "perception/cloud/registration.h"
#include "perception/image/match_series.h"

namespace enfilade::server {
namespace {

using perception::Views;

Eigen::Isometry3d ToIsometry(const Pose2& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << pose.x, pose.y, 0.0;
  T.linear() = Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return T;
}

perception::RegistrationOptions CloudOptions(const closure::DoorClosureOptions& options) {
  perception::RegistrationOptions registration;
  registration.voxel = options.cloud_voxel;
  registration.min_inlier_share = options.min_inlier_share;
  registration.max_fitness = options.max_fitness;
  return registration;
}

// Does the camera look away from the place, into the map? For a candidate the robot stood before the door and looked at
// it.
bool LooksAway(const closure::ComparedPlace& place, const storage::Evidence& item) {
  bool faces_place = true;
  if (!place.link_point->is_candidate() && item.T_map_robot) {
    faces_place = Between(*item.T_map_robot, place.anchor->T_map_place).x > 0.0;
  }
  return (item.kind == storage::EvidenceKind::kFrontImage) != faces_place;
}

std::vector<Views> AsSeries(std::span<const perception::FeatureSet* const> images) {
  std::vector<Views> series;
  for (const perception::FeatureSet* image : images) series.push_back({.front = image, .rear = nullptr});
  return series;
}

const storage::Evidence* FindCloud(const std::vector<storage::Evidence>& kept) {
  for (const storage::Evidence& item : kept) {
    if (item.kind == storage::EvidenceKind::kCloud) return &item;
  }
  return nullptr;
}

bool IsBetter(const perception::Registration& a, const perception::Registration& b) {
  if (a.accepted != b.accepted) return a.accepted;
  return a.inlier_share > b.inlier_share;
}

}  // namespace

perception::ImageMatchOptions ImageMatchOptionsOf(const closure::DoorClosureOptions& options) {
  perception::ImageMatchOptions match;
  match.ratios = {.sift = options.image_sift_ratio, .akaze = options.image_akaze_ratio};
  match.tolerance = options.image_tolerance;
  match.threshold = options.image_threshold;
  match.min_share = options.image_min_share;
  return match;
}

// Those that look into the map (`away`) or at the door, images_compared at most, the nearest to the door's moment
// first.
absl::StatusOr<std::vector<const perception::FeatureSet*>> PlaceComparer::FindKeptImages(
    const std::vector<storage::Evidence>& kept, const closure::ComparedPlace& place, bool away) const {
  std::vector<const perception::FeatureSet*> images;
  for (const storage::Evidence& item : kept) {
    if (item.kind == storage::EvidenceKind::kCloud || LooksAway(place, item) != away) continue;
    if (images.size() >= static_cast<std::size_t>(options_.images_compared)) break;
    ENFILADE_ASSIGN_OR_RETURN(const auto* features, views_.Features(item.content, /*keep=*/true));
    if (features != nullptr) images.push_back(features);
  }
  return images;
}

// The median over the robot's images, for the best of the kept ones. Two of the robot's images are tried first: if they
// have no match at all, the others would cost much and say the same.
absl::StatusOr<closure::ImageComparison> PlaceComparer::MatchImages(
    const std::vector<const perception::FeatureSet*>& kept,
    const std::vector<const perception::FeatureSet*>& now) const {
  const std::vector<Views> series = AsSeries(now);
  std::vector<Views> first = {series.front()};
  if (series.size() > 2) first.push_back(series[series.size() / 2]);
  const perception::ImageMatchOptions match_options = ImageMatchOptionsOf(options_);
  closure::ImageComparison comparison;
  for (const perception::FeatureSet* image : kept) {
    const Views view{.front = image, .rear = nullptr};
    ENFILADE_ASSIGN_OR_RETURN(const auto trial, perception::MatchSeries(view, first, match_options));
    comparison.other_place = comparison.other_place || trial.other_place;
    if (std::all_of(trial.scores.begin(), trial.scores.end(), [](int score) { return score == 0; })) continue;
    ENFILADE_ASSIGN_OR_RETURN(const auto match, perception::MatchSeries(view, series, match_options));
    comparison.matches = std::max(comparison.matches, match.score);
    comparison.agree = comparison.agree || match.accepted;
    comparison.other_place = comparison.other_place || match.other_place;
    if (comparison.agree) break;
  }
  if (comparison.agree) comparison.other_place = false;
  return comparison;
}

absl::Status PlaceComparer::CompareImages(const std::vector<storage::Evidence>& kept,
                                          closure::ComparedPlace& place) const {
  place.images_compared = true;
  if (robot_.ahead.empty() && robot_.back.empty()) {
    place.evidence.missing = "the robot has no images behind the door";
    return absl::OkStatus();
  }
  for (const bool away : {true, false}) {
    const auto& now = away ? robot_.ahead : robot_.back;
    if (now.empty()) continue;
    ENFILADE_ASSIGN_OR_RETURN(const auto images, FindKeptImages(kept, place, away));
    if (images.empty()) continue;
    ENFILADE_ASSIGN_OR_RETURN(place.evidence.images, MatchImages(images, now));
    return absl::OkStatus();
  }
  place.evidence.missing = "no images are kept of the place that look the same way";
  return absl::OkStatus();
}

// Where the robot may have taken its cloud, in the entered map. RegisterClouds also tries each turned on the spot.
std::vector<Pose2> PlaceComparer::InitialGuesses(const closure::ComparedPlace& place,
                                                 const Pose2& T_map_evidence) const {
  std::vector<Pose2> guesses;
  const std::optional<PoseWithCovariance>& predicted = place.evidence.predicted;
  if (predicted) guesses.push_back(predicted->pose * Inverse(robot_.T_cloud_robot));
  if (predicted && graph::ErrorEllipse95(predicted->covariance).semi_major_m <= options_.sure_radius) return guesses;
  if (place.link_point->is_candidate()) {
    // Its evidence was taken before the door, looking at it; the robot has come out of the door towards it.
    guesses.push_back(T_map_evidence * Pose2{options_.latch_distance - robot_.beyond_door, 0.0, M_PI});
  } else {
    const Pose2& T_map_place = place.anchor->T_map_place;
    guesses.push_back(T_map_place * Pose2{robot_.beyond_door, 0.0, 0.0});
    guesses.push_back(T_map_place * Pose2{-robot_.beyond_door, 0.0, M_PI});
  }
  return guesses;
}

absl::Status PlaceComparer::CompareClouds(const std::vector<storage::Evidence>& kept,
                                          closure::ComparedPlace& place) const {
  place.clouds_compared = true;
  const auto miss = [&place](const std::string& what) {
    std::string& missing = place.evidence.missing;
    missing += (missing.empty() ? "" : "; ") + what;
    return absl::OkStatus();
  };
  if (robot_.cloud == nullptr) return miss("the robot has no cloud behind the door");
  const storage::Evidence* item = FindCloud(kept);
  if (item == nullptr) return miss("no cloud is kept of the place");
  ENFILADE_ASSIGN_OR_RETURN(const perception::Cloud* target,
                            views_.Points(item->content, static_cast<sensor::CloudEncoding>(item->encoding)));
  if (target == nullptr) return miss("the cloud that is kept of the place cannot be used");
  const Pose2 T_map_evidence = item->T_map_robot.value_or(place.anchor->T_map_place);

  std::optional<perception::Registration> best;
  for (const Pose2& T_map_cloud : InitialGuesses(place, T_map_evidence)) {
    auto registration = perception::RegisterClouds(
        *robot_.cloud, *target, ToIsometry(Between(T_map_evidence, T_map_cloud)), CloudOptions(options_));
    // The points are out of bounds. They are the robot's, so trying again would not help.
    if (!registration.ok()) return miss(std::string(registration.status().message()));
    if (!best || IsBetter(*registration, *best)) best = *std::move(registration);
    if (best->accepted) break;
  }
  closure::CloudComparison comparison;
  comparison.rmse = std::isfinite(best->fitness) ? std::sqrt(best->fitness) : 2.0;
  comparison.inlier_share = best->inlier_share;
  comparison.agree = best->accepted;
  const PoseWithCovariance T_map_cloud = perception::RobotInMap({T_map_evidence, place.anchor->covariance}, *best);
  comparison.T_map_robot = Compose(T_map_cloud, {robot_.T_cloud_robot, Eigen::Matrix3d::Zero()});
  place.evidence.clouds = comparison;
  return absl::OkStatus();
}

}  // namespace enfilade::server
