// SPDX-License-Identifier: Apache-2.0
#include "core/prior/slam/plan_tracking.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/base/time.h"
#include "core/prior/slam/map_log.h"
#include "core/slam/matching/correlative_matcher.h"
#include "core/slam/matching/likelihood_field.h"
#include "core/slam/matching/motion_model.h"
#include "core/slam/matching/scan_matcher.h"
#include "core/slam/matching/scan_points.h"
#include "core/slam/matching/search_table.h"
#include "core/slam/submaps/robot_rays.h"

namespace enfilade::prior {
namespace {

constexpr double kFieldCell = 0.1;     // m
constexpr double kFieldReach = 1.0;    // m
constexpr double kPlanSigma = 0.2;     // m, of hits about the plan's walls
constexpr double kSearchSigma = 0.25;  // m
constexpr int kSearchLevels = 5;
constexpr double kPointSpacing = 0.1;   // m
constexpr double kStartSigma = 0.5;     // m
constexpr double kStartYawSigma = 0.1;  // rad
constexpr double kWindowSigmas = 3.0;
constexpr double kMostHalfWidth = 4.0;  // m
constexpr double kMostHalfAngle = 1.2;  // rad
constexpr double kLeastMatched = 0.4;   // share of hits, of a scan that says where the robot is

struct PlanFields {
  slam::LikelihoodField field{kFieldCell, kFieldReach};
  slam::SearchTable table{Knob("K_SEARCH", kSearchSigma), kSearchLevels};

  explicit PlanFields(const std::vector<WallFace>& faces) {
    std::vector<Eigen::Vector2d> points;
    for (const WallFace& face : faces) {
      const Eigen::Vector2d way = face.to - face.from;
      const int pieces = std::max(1, static_cast<int>(std::ceil(way.norm() / (0.5 * kFieldCell))));
      for (int i = 0; i <= pieces; ++i) points.emplace_back(face.from + way * i / pieces);
    }
    field.Add(points);
    table.Update(field, field.window());
  }
};

slam::FieldMatchOptions MatchOptions() {
  slam::FieldMatchOptions options;
  options.sigma = Knob("K_SIGMA", kPlanSigma);
  options.matched_distance = 1.5 * options.sigma;
  options.effective_beams = Knob("K_BEAMS", 10);
  return options;
}

// The derivative of T_a_b * T_b_c by T_a_b.
Eigen::Matrix3d ComposedBy(const Pose2& T_a_b, const Pose2& T_b_c) {
  const Eigen::Vector2d arm = (T_a_b * T_b_c).translation() - T_a_b.translation();
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
  jacobian(0, 2) = -arm.y();
  jacobian(1, 2) = arm.x();
  return jacobian;
}

struct FilterStep {
  Pose2 predicted;
  Eigen::Matrix3d predicted_covariance;
  Eigen::Matrix3d by_last;  // derivative of the prediction by the pose before
  PoseWithCovariance filtered;
};

class Tracker {
 public:
  Tracker(const std::vector<WallFace>& faces, const slam::SlamOptions& options) : fields_(faces), options_(options) {}

  PlanTrack Run(const std::vector<sensor::PairedScan>& scans, const Pose2& T_map_first) {
    for (std::size_t i = 0; i < scans.size(); ++i) {
      FilterStep step = i == 0 ? First(T_map_first) : Predicted(scans[i - 1], scans[i]);
      Correct(scans[i], step);
      if (i > 0) {
        last_step_ = slam::Step{Between(steps_.back().filtered.pose, step.filtered.pose),
                                ToSeconds(scans[i].scan.time - scans[i - 1].scan.time)};
      }
      steps_.push_back(step);
    }
    return {Smoothed(), scans.empty() ? 0.0 : matched_ / static_cast<double>(scans.size())};
  }

 private:
  static FilterStep First(const Pose2& T_map_first) {
    FilterStep step;
    step.predicted = T_map_first;
    step.predicted_covariance =
        Eigen::Vector3d(kStartSigma * kStartSigma, kStartSigma * kStartSigma, kStartYawSigma * kStartYawSigma)
            .asDiagonal();
    step.by_last.setIdentity();
    return step;
  }

  FilterStep Predicted(const sensor::PairedScan& before, const sensor::PairedScan& now) const {
    const slam::PredictedMotion motion =
        slam::PredictMotion(before.T_odom_robot, now.T_odom_robot, last_step_,
                            ToSeconds(now.scan.time - before.scan.time), options_.motion);
    const PoseWithCovariance& last = steps_.back().filtered;
    Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
    noise.diagonal() << motion.sigma_translation * motion.sigma_translation,
        motion.sigma_translation * motion.sigma_translation, motion.sigma_yaw * motion.sigma_yaw;
    const PoseWithCovariance next = Compose(last, {motion.T_last_now, noise});
    return {next.pose, next.covariance, ComposedBy(last.pose, motion.T_last_now), {}};
  }

  // By the scan, if the plan shows what it has seen.
  void Correct(const sensor::PairedScan& scan, FilterStep& step) {
    step.filtered = {step.predicted, step.predicted_covariance};
    const auto points = slam::Thinned(
        slam::RobotRays(scan.scan, {options_.max_range, options_.occupancy.no_return_range}).hits, kPointSpacing);
    if (points.empty()) return;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(step.predicted_covariance.topLeftCorner<2, 2>(),
                                                              Eigen::EigenvaluesOnly);
    slam::SearchWindow window;
    window.centre = step.predicted;
    window.sigma_translation = std::sqrt(axes.eigenvalues()(1)) + kFieldCell;
    window.sigma_yaw = std::sqrt(step.predicted_covariance(2, 2)) + 0.02;
    window.half_width = std::min(kWindowSigmas * window.sigma_translation, kMostHalfWidth);
    window.half_angle = std::min(kWindowSigmas * window.sigma_yaw, kMostHalfAngle);
    const slam::SearchResult found = slam::SearchPose(fields_.table, points, window);
    const slam::PosePrior prior{step.predicted, step.predicted_covariance.inverse()};
    const slam::MatchResult match =
        slam::MatchToField(fields_.field, points, found.score > 0 ? found.pose : step.predicted, prior, MatchOptions());
    matched_ += match.matched_share;
    if (match.matched_share < Knob("K_LEAST", kLeastMatched)) return;
    const Eigen::Matrix3d covariance = (prior.information + match.information).inverse();
    step.filtered = {match.T_submap_robot, 0.5 * (covariance + covariance.transpose())};
  }

  std::vector<Pose2> Smoothed() const {
    std::vector<Pose2> poses;
    for (const FilterStep& step : steps_) poses.push_back(step.filtered.pose);
    for (std::size_t i = steps_.size(); i-- > 1;) {
      const FilterStep& next = steps_[i];
      const PoseWithCovariance& here = steps_[i - 1].filtered;
      const Eigen::Matrix3d gain = here.covariance * next.by_last.transpose() * next.predicted_covariance.inverse();
      const Eigen::Vector3d change(poses[i].x - next.predicted.x, poses[i].y - next.predicted.y,
                                   WrapAngle(poses[i].yaw - next.predicted.yaw));
      const Eigen::Vector3d correction = gain * change;
      poses[i - 1] = {here.pose.x + correction.x(), here.pose.y + correction.y(),
                      WrapAngle(here.pose.yaw + correction.z())};
    }
    return poses;
  }

  PlanFields fields_;
  const slam::SlamOptions& options_;
  std::vector<FilterStep> steps_;
  std::optional<slam::Step> last_step_;
  double matched_ = 0;
};

}  // namespace

PlanTrack TrackInPlan(const std::vector<WallFace>& faces, const std::vector<sensor::PairedScan>& scans,
                      const Pose2& T_map_first, const slam::SlamOptions& options) {
  return Tracker(faces, options).Run(scans, T_map_first);
}

}  // namespace enfilade::prior
