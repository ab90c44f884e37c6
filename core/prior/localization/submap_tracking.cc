// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/submap_tracking.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/status_macros.h"
#include "core/slam/matching/likelihood_field.h"
#include "core/slam/matching/scan_matcher.h"

namespace enfilade::prior {
namespace {

constexpr double kFieldReach = 1.0;    // m
constexpr double kLeastMatched = 0.5;  // share of a submap's points
constexpr double kGateSigma = 0.4;     // m: by so much the plan may be wrong within a submap
constexpr double kGateYaw = 0.1;       // rad
constexpr std::size_t kMostPoints = 2000;

// In the frame of the plan's metres (MetresOf), in which the plan is as large as the building.
std::vector<Eigen::Vector2d> WallsNear(const PlanField& field, const Eigen::Matrix2d& metres,
                                       const Eigen::Vector2d& centre, double radius) {
  std::vector<Eigen::Vector2d> walls;
  std::vector<WallFace> faces = field.faces();
  for (WallFace& face : faces) {
    face.from = metres * face.from;
    face.to = metres * face.to;
  }
  for (const Eigen::Vector2d& point : PointsOn(faces, 0.5 * PlanField::kResolution)) {
    if ((point - centre).norm() <= radius) walls.push_back(point);
  }
  return walls;
}

}  // namespace

TrackedSubmap TrackSubmap(const PlanField& field, const std::vector<Eigen::Vector2d>& points, const PlanState& guess,
                          const PlanLocalizerOptions& options) {
  TrackedSubmap tracked{.state = guess};
  std::vector<Eigen::Vector2d> near;
  double radius = 0;
  const std::size_t step = std::max<std::size_t>(1, points.size() / kMostPoints);
  for (std::size_t i = 0; i < points.size(); i += step) {
    near.emplace_back(points[i].x(), guess.mirrored ? -points[i].y() : points[i].y());
    radius = std::max(radius, points[i].norm());
  }
  const Eigen::Matrix2d metres = MetresOf(guess, field.axis());
  const Eigen::Vector2d at = metres * guess.translation();
  slam::LikelihoodField walls(0.5 * PlanField::kResolution, kFieldReach);
  walls.Add(WallsNear(field, metres, at, radius + 2 * kFieldReach));
  if (near.empty() || walls.window().empty()) return tracked;
  const double sigma = std::hypot(options.sigma_hit, options.sigma_plan);
  const slam::FieldMatchOptions matching{.sigma = sigma, .matched_distance = 2 * sigma};
  const slam::MatchResult match = slam::MatchToField(walls, near, {at.x(), at.y(), guess.yaw}, {}, matching);
  const Eigen::Vector2d plan = metres.inverse() * match.T_submap_robot.translation();
  tracked.state.x = plan.x();
  tracked.state.y = plan.y();
  tracked.state.yaw = match.T_submap_robot.yaw;
  tracked.information = match.information;
  tracked.matched = match.matched_share;
  tracked.accepted = match.converged && match.matched_share >= kLeastMatched;
  return tracked;
}

absl::StatusOr<PlanDrive> LocateDrive(const PlanField& field, const std::vector<ControlPair>& pairs,
                                      const MappedDrive& mapped, const PlanLocalizerOptions& options,
                                      const KeepGoing& keep_going) {
  const std::vector<DriveLook>& looks = mapped.looks;
  const std::vector<DriveSubmap>& submaps = mapped.submaps;
  PlanDrive drive;
  PlanLocalizer localizer(field, pairs, options, keep_going);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const Pose2& T_map_robot = looks[i].look.T_map_robot;
    drive.steps.push_back(localizer.Add(looks[i].look));
    if (keep_going) ENFILADE_RETURN_IF_ERROR(keep_going());
    const bool finished = i + 1 == looks.size() || looks[i + 1].submap != looks[i].submap;
    if (!finished || !drive.steps.back().confident) continue;
    const auto submap =
        std::find_if(submaps.begin(), submaps.end(), [&](const DriveSubmap& one) { return one.id == looks[i].submap; });
    if (submap == submaps.end()) continue;
    const PlanState guess =
        Moved(drive.steps.back().modes.front().mean, Between(T_map_robot, submap->T_map_submap), field.axis());
    TrackedSubmap tracked = TrackSubmap(field, submap->points, guess, options);
    tracked.submap = submap->id;
    drive.submaps.push_back(tracked);
    if (!tracked.accepted) continue;
    Eigen::Matrix3d information = tracked.information;
    information.diagonal().array() += 1e-3;  // a corridor
    Eigen::Matrix3d covariance = information.inverse();
    covariance.diagonal() += Eigen::Vector3d(kGateSigma, kGateSigma, kGateYaw).cwiseAbs2();
    localizer.Gate(Moved(tracked.state, Between(submap->T_map_submap, T_map_robot), field.axis()), covariance);
  }
  drive.particles = localizer.particles();
  return drive;
}

}  // namespace enfilade::prior
