// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/place_comparison.h"

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

perception::ImageMatchOptions MatchOptions(const closure::DoorClosureOptions& options) {
  perception::ImageMatchOptions match;
  match.ratios = {.sift = options.image_sift_ratio, .akaze = options.image_akaze_ratio};
  match.tolerance = options.image_tolerance;
  match.threshold = options.image_threshold;
  match.min_share = options.image_min_share;
  return match;
}

perception::RegistrationOptions CloudOptions(const closure::DoorClosureOptions& options) {
  perception::RegistrationOptions registration;
  registration.voxel = options.cloud_voxel;
  registration.min_inlier_share = options.min_inlier_share;
  registration.max_fitness = options.max_fitness;
  return registration;
}

// Does the camera look away from the place, into the map? Of a candidate the robot stood before the door and looked at
// it.
bool LooksAway(const Place& place, const storage::Evidence& item) {
  bool faces_place = true;
  if (!place.link_point->is_candidate() && item.T_map_robot) {
    faces_place = Between(*item.T_map_robot, place.anchor->T_map_place).x > 0.0;
  }
  return (item.kind == storage::EvidenceKind::kFrontImage) != faces_place;
}

// The images kept that look into the map, or those that look at the door, the nearest to the door's moment first.
absl::StatusOr<std::vector<const perception::FeatureSet*>> StoredImages(const storage::CallContext& context,
                                                                        const Place& place, bool away,
                                                                        const closure::DoorClosureOptions& options,
                                                                        StoredViews& views) {
  std::vector<const perception::FeatureSet*> images;
  for (const storage::Evidence& item : place.evidence) {
    if (item.kind == storage::EvidenceKind::kCloud || LooksAway(place, item) != away) continue;
    if (images.size() >= static_cast<std::size_t>(options.images_compared)) break;
    ENFILADE_ASSIGN_OR_RETURN(const auto* features, views.Features(context, item.content, /*keep=*/true));
    if (features != nullptr) images.push_back(features);
  }
  return images;
}

std::vector<Views> AsSeries(std::span<const perception::FeatureSet* const> images) {
  std::vector<Views> series;
  for (const perception::FeatureSet* image : images) series.push_back({.front = image, .rear = nullptr});
  return series;
}

// The median over the moments, of the best of the images kept. Two moments are looked at first: where nothing at all is
// alike, more would cost much and say the same.
absl::StatusOr<closure::ImageWitness> Match(const std::vector<const perception::FeatureSet*>& stored,
                                            const std::vector<const perception::FeatureSet*>& now,
                                            const closure::DoorClosureOptions& options) {
  const std::vector<Views> series = AsSeries(now);
  std::vector<Views> first = {series.front()};
  if (series.size() > 2) first.push_back(series[series.size() / 2]);
  const perception::ImageMatchOptions match_options = MatchOptions(options);
  closure::ImageWitness witness;
  for (const perception::FeatureSet* image : stored) {
    const Views view{.front = image, .rear = nullptr};
    ENFILADE_ASSIGN_OR_RETURN(const auto glance, perception::MatchSeries(view, first, match_options));
    if (std::all_of(glance.scores.begin(), glance.scores.end(), [](int score) { return score == 0; })) continue;
    ENFILADE_ASSIGN_OR_RETURN(const auto match, perception::MatchSeries(view, series, match_options));
    witness.matches = std::max(witness.matches, match.score);
    witness.agree = witness.agree || match.accepted;
    if (witness.agree) break;
  }
  return witness;
}

const storage::Evidence* FindCloud(const Place& place) {
  for (const storage::Evidence& item : place.evidence) {
    if (item.kind == storage::EvidenceKind::kCloud) return &item;
  }
  return nullptr;
}

// Where the robot may have taken its cloud, in the map behind. RegisterClouds also tries each turned on the spot.
std::vector<Pose2> FirstGuesses(const Place& place, const ViewsBehind& behind, const Pose2& T_map_evidence,
                                const closure::DoorClosureOptions& options) {
  std::vector<Pose2> guesses;
  if (place.predicted) guesses.push_back(place.predicted->pose * Inverse(behind.T_cloud_robot));
  if (place.predicted && graph::ErrorEllipse95(place.predicted->covariance).semi_major_m <= options.sure_radius) {
    return guesses;
  }
  if (place.link_point->is_candidate()) {
    // Its evidence was taken before the door, looking at it; the robot has come out of the door towards it.
    guesses.push_back(T_map_evidence * Pose2{options.latch_distance - behind.beyond, 0.0, M_PI});
  } else {
    const Pose2& T_map_place = place.anchor->T_map_place;
    guesses.push_back(T_map_place * Pose2{behind.beyond, 0.0, 0.0});
    guesses.push_back(T_map_place * Pose2{-behind.beyond, 0.0, M_PI});
  }
  return guesses;
}

bool IsBetter(const perception::Registration& a, const perception::Registration& b) {
  if (a.accepted != b.accepted) return a.accepted;
  return a.inlier_share > b.inlier_share;
}

}  // namespace

absl::StatusOr<closure::PlaceEvidence> CompareImages(const storage::CallContext& context, const Place& place,
                                                     const ViewsBehind& behind,
                                                     const closure::DoorClosureOptions& options, StoredViews& views) {
  closure::PlaceEvidence evidence;
  evidence.link_point = place.link_point->id;
  evidence.map = place.anchor->map;
  evidence.distance = place.distance;
  evidence.predicted = place.predicted;
  if (behind.ahead.empty() && behind.back.empty()) {
    evidence.missing = "the robot has no images behind the door";
    return evidence;
  }
  for (const bool away : {true, false}) {
    const auto& now = away ? behind.ahead : behind.back;
    if (now.empty()) continue;
    ENFILADE_ASSIGN_OR_RETURN(const auto stored, StoredImages(context, place, away, options, views));
    if (stored.empty()) continue;
    ENFILADE_ASSIGN_OR_RETURN(evidence.images, Match(stored, now, options));
    return evidence;
  }
  evidence.missing = "no images are kept of the place that look the same way";
  return evidence;
}

absl::Status CompareClouds(const storage::CallContext& context, const Place& place, const ViewsBehind& behind,
                           const closure::DoorClosureOptions& options, StoredViews& views,
                           closure::PlaceEvidence& evidence) {
  const auto miss = [&evidence](const std::string& what) {
    evidence.missing += (evidence.missing.empty() ? "" : "; ") + what;
    return absl::OkStatus();
  };
  if (behind.cloud == nullptr) return miss("the robot has no cloud behind the door");
  const storage::Evidence* kept = FindCloud(place);
  if (kept == nullptr) return miss("no cloud is kept of the place");
  ENFILADE_ASSIGN_OR_RETURN(const perception::Cloud* target,
                            views.Points(context, kept->content, static_cast<sensor::CloudEncoding>(kept->encoding)));
  if (target == nullptr) return miss("the cloud that is kept of the place cannot be used");
  const Pose2 T_map_evidence = kept->T_map_robot.value_or(place.anchor->T_map_place);

  std::optional<perception::Registration> best;
  for (const Pose2& T_map_cloud : FirstGuesses(place, behind, T_map_evidence, options)) {
    auto registration = perception::RegisterClouds(
        *behind.cloud, *target, ToIsometry(Between(T_map_evidence, T_map_cloud)), CloudOptions(options));
    // Points too far away to be any: of the robot's making, so no reason to try again.
    if (!registration.ok()) return miss(std::string(registration.status().message()));
    if (!best || IsBetter(*registration, *best)) best = *std::move(registration);
    if (best->accepted) break;
  }
  closure::CloudWitness witness;
  witness.rmse = std::isfinite(best->fitness) ? std::sqrt(best->fitness) : 2.0;
  witness.inlier_share = best->inlier_share;
  witness.agree = best->accepted;
  const PoseWithCovariance T_map_cloud = perception::RobotInMap({T_map_evidence, place.anchor->covariance}, *best);
  witness.T_map_robot = Compose(T_map_cloud, {behind.T_cloud_robot, Eigen::Matrix3d::Zero()});
  evidence.clouds = witness;
  return absl::OkStatus();
}

}  // namespace enfilade::server
