#include "server/app/closure/place_comparison.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/search_radius.h"
#include "perception/cloud/registration.h"

namespace enfilade::server {
namespace {

using perception::Views;

Eigen::Isometry3d ToIsometry(const Pose2& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << pose.x, pose.y, 0.0;
  T.linear() = Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return T;
}

perception::ImageMatchOptions MatchOptions(const ClosureOptions& options) {
  perception::ImageMatchOptions match;
  match.threshold = options.image_threshold;
  match.min_share = options.image_min_share;
  return match;
}

perception::RegistrationOptions CloudOptions(const ClosureOptions& options) {
  perception::RegistrationOptions registration;
  registration.voxel = options.cloud_voxel;
  registration.min_inlier_share = options.min_inlier_share;
  registration.max_fitness = options.max_fitness;
  return registration;
}

// The stored moments, the nearest to the door's first: the i-th of each camera makes one.
absl::StatusOr<std::vector<Views>> StoredSeries(const CallContext& context, const Place& place,
                                                const ClosureOptions& options, StoredViews& views) {
  std::vector<const perception::FeatureSet*> front, rear;
  for (const Evidence& item : place.evidence) {
    if (item.kind == EvidenceKind::kCloud) continue;
    auto& of_camera = item.kind == EvidenceKind::kFrontImage ? front : rear;
    if (of_camera.size() >= static_cast<std::size_t>(options.images_compared)) continue;
    ENFILADE_ASSIGN_OR_RETURN(const auto* features, views.Features(context, item.content, /*keep=*/true));
    if (features != nullptr) of_camera.push_back(features);
  }
  std::vector<Views> series(std::max(front.size(), rear.size()));
  for (std::size_t i = 0; i < front.size(); ++i) series[i].front = front[i];
  for (std::size_t i = 0; i < rear.size(); ++i) series[i].rear = rear[i];
  return series;
}

const Evidence* FindCloud(const Place& place) {
  for (const Evidence& item : place.evidence) {
    if (item.kind == EvidenceKind::kCloud) return &item;
  }
  return nullptr;
}

// Where the robot may have taken its cloud, in the map behind. RegisterClouds also tries each turned on the spot.
std::vector<Pose2> FirstGuesses(const Place& place, const ViewsBehind& behind, const Pose2& T_map_evidence,
                                const ClosureOptions& options) {
  std::vector<Pose2> guesses;
  if (place.predicted) guesses.push_back(place.predicted->pose * Inverse(behind.T_cloud_robot));
  if (place.predicted && ErrorEllipse95(place.predicted->covariance).semi_major_m <= options.sure_radius) {
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

absl::StatusOr<PlaceEvidence> CompareImages(const CallContext& context, const Place& place, const ViewsBehind& behind,
                                            const ClosureOptions& options, StoredViews& views) {
  PlaceEvidence evidence;
  evidence.link_point = place.link_point->id;
  evidence.map = place.anchor->map;
  evidence.distance = place.distance;
  evidence.predicted = place.predicted;
  if (behind.series.empty()) {
    evidence.missing = "the robot has no images behind the door";
    return evidence;
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Views> stored, StoredSeries(context, place, options, views));
  if (stored.empty()) {
    evidence.missing = "no images are kept of the place";
    return evidence;
  }
  ImageWitness witness;
  for (const Views& moment : stored) {
    ENFILADE_ASSIGN_OR_RETURN(const perception::SeriesMatch match,
                              perception::MatchSeries(moment, behind.series, MatchOptions(options)));
    witness.matches = std::max(witness.matches, match.score);
    witness.agree = witness.agree || match.accepted;
    if (witness.agree) break;
  }
  evidence.images = witness;
  return evidence;
}

absl::Status CompareClouds(const CallContext& context, const Place& place, const ViewsBehind& behind,
                           const ClosureOptions& options, StoredViews& views, PlaceEvidence& evidence) {
  const auto miss = [&evidence](const std::string& what) {
    evidence.missing += (evidence.missing.empty() ? "" : "; ") + what;
    return absl::OkStatus();
  };
  if (behind.cloud == nullptr) return miss("the robot has no cloud behind the door");
  const Evidence* kept = FindCloud(place);
  if (kept == nullptr) return miss("no cloud is kept of the place");
  ENFILADE_ASSIGN_OR_RETURN(const perception::Cloud* target,
                            views.Points(context, kept->content, static_cast<CloudEncoding>(kept->encoding)));
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
  CloudWitness witness;
  witness.rmse = std::isfinite(best->fitness) ? std::sqrt(best->fitness) : 2.0;
  witness.inlier_share = best->inlier_share;
  witness.agree = best->accepted;
  const PoseWithCovariance T_map_cloud = perception::RobotInMap({T_map_evidence, place.anchor->covariance}, *best);
  witness.T_map_robot = Compose(T_map_cloud, {behind.T_cloud_robot, Eigen::Matrix3d::Zero()});
  evidence.clouds = witness;
  return absl::OkStatus();
}

}  // namespace enfilade::server
