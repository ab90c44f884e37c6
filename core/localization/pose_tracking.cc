// SPDX-License-Identifier: Apache-2.0
#include "core/localization/pose_tracking.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/slam/loops/edge_information.h"
#include "core/slam/matching/correlative_matcher.h"
#include "core/slam/matching/motion_model.h"
#include "core/slam/matching/scan_matcher.h"
#include "core/slam/slam_options.h"

namespace enfilade::localization {
namespace {

// The fit below which a pose is searched for around the prediction, as a share of the hits on known ground; how far.
constexpr double kFits = 0.85;
constexpr double kSlip = 0.3;        // m
constexpr double kSlipAngle = 0.25;  // rad
constexpr double kWideSigma = 0.15;  // m, of the first refinement, which starts from the search's coarse steps

slam::MatchResult Refine(const SearchableMap& map, const QueryPoints& points, const Pose2& guess,
                         const slam::PosePrior& prior, double sigma) {
  slam::FieldMatchOptions field;
  field.sigma = std::max(field.sigma, sigma);
  return slam::MatchToField(map.walls(), points.hits, guess, prior, field);
}

// The pose of one scan, predicted by odometry: refined from the prediction and, if little fits there, from the best
// place around it. Wheels slip more than the model of motion says, at times.
slam::MatchResult RefinePredicted(const SearchableMap& map, const QueryPoints& points, const slam::PosePrior& prior,
                                  const LocalizationOptions& options) {
  slam::MatchResult near = Refine(map, points, prior.pose, prior, 0.0);
  const ScanEvidence evidence = Compare(map, points, near.T_submap_robot, options);
  if (evidence.matched >= kFits * evidence.known() || points.searched.empty()) return near;
  slam::SearchWindow window;
  window.centre = prior.pose;
  window.half_width = kSlip;
  window.half_angle = kSlipAngle;
  window.sigma_translation = kSlip;
  window.sigma_yaw = kSlipAngle;
  const slam::SearchResult around = slam::SearchPose(map.table(), points.searched, window);
  const slam::MatchResult found = Refine(map, points, around.pose, {around.pose, prior.information}, 0.0);
  const double gain = Compare(map, points, found.T_submap_robot, options).log_likelihood - evidence.log_likelihood;
  return gain > 0.0 ? found : near;
}

Pose2 RefineSeed(const SearchableMap& map, const QueryPoints& points, const Pose2& guess) {
  const Pose2 near = Refine(map, points, guess, {}, kWideSigma).T_submap_robot;
  return Refine(map, points, near, {}, 0.0).T_submap_robot;
}

// The motion between two scans by odometry, with its covariance.
PoseWithCovariance MotionBetween(const TrackedScan& from, const TrackedScan& to) {
  const slam::PredictedMotion motion =
      slam::PredictMotion(from.T_odom_robot, to.T_odom_robot, std::nullopt, 1.0, slam::MotionOptions());
  PoseWithCovariance result{motion.T_last_now, Eigen::Matrix3d::Zero()};
  result.covariance.diagonal() << motion.sigma_translation * motion.sigma_translation,
      motion.sigma_translation * motion.sigma_translation, motion.sigma_yaw * motion.sigma_yaw;
  return result;
}

double WeightOf(std::size_t scan, const LocalizationOptions& options) {
  return options.effective_beams * (scan == 0 ? 1.0 : options.further_scan);
}

void AddShare(const ScanEvidence& one, double share, ScanEvidence& sum) {
  sum.log_likelihood += share * one.log_likelihood;
  sum.known_log_likelihood += share * one.known_log_likelihood;
  sum.matched += share * one.matched;
  sum.free += share * one.free;
  sum.through += share * one.through;
  sum.unknown += share * one.unknown;
}

}  // namespace

std::optional<TrackedPose> TrackPose(const SearchableMap& map, const std::vector<TrackedScan>& scans, std::size_t seed,
                                     const Pose2& T_map_robot, double give_up, const LocalizationOptions& options) {
  // Back to the first scan. What is gathered on the way back is used only to give up early.
  Pose2 first = RefineSeed(map, scans[seed].points, T_map_robot);
  double back = 0.0;
  for (std::size_t i = seed; i > 0; --i) {
    back += options.effective_beams * options.further_scan *
            Compare(map, scans[i].points, first, options).known_log_likelihood;
    if (back < give_up) return std::nullopt;
    const PoseWithCovariance motion = MotionBetween(scans[i], scans[i - 1]);
    const Pose2 predicted = first * motion.pose;
    const slam::PosePrior prior{
        predicted, slam::InformationOf(std::sqrt(motion.covariance(0, 0)), std::sqrt(motion.covariance(2, 2)))};
    first = RefinePredicted(map, scans[i - 1].points, prior, options).T_submap_robot;
  }
  const auto seeing =
      std::count_if(scans.begin(), scans.end(), [](const TrackedScan& scan) { return !scan.points.beams.empty(); });
  const double share = 1.0 / static_cast<double>(std::max<std::ptrdiff_t>(seeing, 1));
  TrackedPose result;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    slam::MatchResult match;
    Eigen::Matrix3d information;
    if (i == 0) {
      match = Refine(map, scans[i].points, first, {}, 0.0);
      information = match.information;
    } else {
      PoseWithCovariance predicted = Compose(result.T_map_robot, MotionBetween(scans[i - 1], scans[i]));
      const slam::PosePrior prior{predicted.pose, predicted.covariance.inverse()};
      match = RefinePredicted(map, scans[i].points, prior, options);
      information = match.information + prior.information;
    }
    result.T_map_robot.pose = match.T_submap_robot;
    // A direction that nothing constrains gets a variance that is large, but finite.
    information.diagonal() += Eigen::Vector3d(1e-4, 1e-4, 1e-2);
    result.T_map_robot.covariance = information.inverse();
    const ScanEvidence evidence = Compare(map, scans[i].points, match.T_submap_robot, options);
    if (!scans[i].points.beams.empty()) AddShare(evidence, share, result.evidence);
    result.log_likelihood += WeightOf(i, options) * evidence.log_likelihood;
    result.known_log_likelihood += WeightOf(i, options) * evidence.known_log_likelihood;
    if (result.known_log_likelihood < give_up) return std::nullopt;
  }
  result.T_map_robot.covariance.diagonal() +=
      Eigen::Vector3d(options.sigma_floor * options.sigma_floor, options.sigma_floor * options.sigma_floor,
                      options.yaw_floor * options.yaw_floor);
  return result;
}

}  // namespace enfilade::localization
