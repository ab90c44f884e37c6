// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/registration.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "perception/cloud/gauss_newton.h"
#include "perception/cloud/nearest_points.h"
#include "perception/cloud/surfels.h"

namespace enfilade::perception {
namespace {

constexpr std::size_t kFewestPoints = 50;  // of a thinned cloud; fewer would fit almost anywhere

// A thinned cloud at one stage's voxel size.
struct Level {
  Surfels surfels;
  NearestPoints tree;
};

absl::StatusOr<Level> MakeLevel(const Cloud& cloud, double voxel, int neighbours) {
  ENFILADE_ASSIGN_OR_RETURN(const Cloud thinned, VoxelFilter(cloud, voxel));
  ENFILADE_ASSIGN_OR_RETURN(NearestPoints tree, NearestPoints::Make(thinned.points));
  Surfels surfels = MakeSurfels(thinned.points, tree, neighbours);
  return Level{std::move(surfels), std::move(tree)};
}

Eigen::AlignedBox3f BoxOf(const std::vector<Eigen::Vector3f>& points) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& point : points) box.extend(point);
  return box;
}

constexpr double kFlat = 0.3;              // less flat surfaces have no direction
constexpr double kHorizontalCosine = 0.8;  // floors and ceilings look alike everywhere

bool IsFlat(const Surfels& surfels, std::size_t i) { return surfels.flatness[i] > kFlat; }

struct Agreement {
  int points = 0;   // distinctive points: without floor and ceiling
  int inside = 0;   // of them, inside the other cloud's box
  int inliers = 0;  // of those

  double share() const { return inside > 0 ? static_cast<double>(inliers) / inside : 0.0; }
  double overlap() const { return points > 0 ? static_cast<double>(inside) / points : 0.0; }
};

// How well `from`, placed at T_to_from, agrees with `to`.
Agreement Compare(const Level& from, const Level& to, const Eigen::Isometry3d& T_to_from,
                  const RegistrationOptions& options) {
  Eigen::AlignedBox3f box = BoxOf(to.surfels.points);
  const Eigen::Vector3f margin = Eigen::Vector3f::Constant(static_cast<float>(options.inlier_distance));
  box.min() -= margin;
  box.max() += margin;
  const double squared_limit = options.inlier_distance * options.inlier_distance;
  const double least_cosine = std::cos(options.inlier_angle);
  Agreement agreement;
  for (std::size_t i = 0; i < from.surfels.points.size(); ++i) {
    const Eigen::Vector3d normal = T_to_from.linear() * from.surfels.normals[i];
    if (IsFlat(from.surfels, i) && std::abs(normal.z()) > kHorizontalCosine) continue;
    ++agreement.points;
    const Eigen::Vector3f moved = (T_to_from * from.surfels.points[i].cast<double>()).cast<float>();
    if (!box.contains(moved)) continue;
    ++agreement.inside;
    const NearPoint near = to.tree.Nearest(moved);
    if (near.index < 0 || near.squared_distance > squared_limit) continue;
    const auto j = static_cast<std::size_t>(near.index);
    if (IsFlat(from.surfels, i) && IsFlat(to.surfels, j)) {
      const Eigen::Vector3d& facing = to.surfels.normals[j];
      const double off_plane = std::abs(facing.dot((moved - to.surfels.points[j]).cast<double>()));
      if (std::abs(normal.dot(facing)) < least_cosine || off_plane > options.inlier_distance / 3.0) continue;
    }
    ++agreement.inliers;
  }
  return agreement;
}

double FitnessOf(const Level& source, const Level& target, const Eigen::Isometry3d& T, double max_distance) {
  double sum = 0.0;
  int count = 0;
  for (const Eigen::Vector3f& point : source.surfels.points) {
    const NearPoint near = target.tree.Nearest((T * point.cast<double>()).cast<float>());
    if (near.index < 0 || near.squared_distance > max_distance * max_distance) continue;
    sum += near.squared_distance;
    ++count;
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

void Measure(const Level& source, const Level& target, const RegistrationOptions& options, Registration& result) {
  const Eigen::Isometry3d& T = result.T_target_source;
  const Agreement there = Compare(source, target, T, options);
  const Agreement back = Compare(target, source, T.inverse(), options);
  result.inlier_share = std::min(there.share(), back.share());
  result.overlap = std::max(there.overlap(), back.overlap());
  result.fitness = FitnessOf(source, target, T, options.max_distance);
}

Eigen::Matrix<double, 6, 6> CovarianceOf(const Alignment& alignment, int neighbours) {
  // Three residuals per point; the points of one surface fit count as one measurement.
  const double measurements = std::max(1.0, 3.0 * alignment.correspondences / neighbours - 6.0);
  const double variance = alignment.weighted_residual / (3.0 * std::max(1, alignment.correspondences));
  Eigen::Matrix<double, 6, 6> H = alignment.normal;
  H.diagonal().array() += 1e-9 * std::max(1.0, H.diagonal().maxCoeff());
  const double inflation = 3.0 * alignment.correspondences / measurements;
  return variance * inflation * H.inverse();
}

struct Levels {
  Level coarse;
  Level fine;
};

absl::StatusOr<Levels> MakeLevels(const Cloud& cloud, const RegistrationOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(Level coarse, MakeLevel(cloud, options.voxel * options.coarse_factor, options.neighbours));
  ENFILADE_ASSIGN_OR_RETURN(Level fine, MakeLevel(cloud, options.voxel, options.neighbours));
  return Levels{std::move(coarse), std::move(fine)};
}

struct Start {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  bool turned = false;
  int iterations = 0;
  double score = 0.0;
};

// Without the overlap a pose outside the other cloud's box could score better.
double ScoreOf(const Registration& result) { return result.inlier_share * result.overlap; }

double LastDistance(const RegistrationOptions& options, double voxels) {
  return std::min(options.max_distance, voxels * options.voxel);
}

// The results of the first stage from all starts, best first.
std::vector<Start> Coarse(const Levels& source, const Levels& target, const Eigen::Isometry3d& guess,
                          const RegistrationOptions& options) {
  const AlignOptions align{.method = options.method,
                           .first_distance = options.max_distance,
                           .last_distance = LastDistance(options, 2.0 * options.coarse_factor),
                           .max_iterations = options.max_iterations};
  std::vector<Start> starts;
  for (const bool turned : {false, true}) {
    if (turned && !options.try_turned) continue;
    for (const double offset : options.yaw_offsets) {
      const double yaw = offset + (turned ? std::numbers::pi : 0.0);
      const Alignment found = Align(source.coarse.surfels, target.coarse.surfels, target.coarse.tree,
                                    guess * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()), align);
      Registration result;
      result.T_target_source = found.T_target_source;
      Measure(source.coarse, target.coarse, options, result);
      starts.push_back({found.T_target_source, turned, found.iterations, ScoreOf(result)});
    }
  }
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.score > b.score; });
  return starts;
}

Registration Refine(const Levels& source, const Levels& target, const Start& start,
                    const RegistrationOptions& options) {
  const Alignment fine = Align(source.fine.surfels, target.fine.surfels, target.fine.tree, start.T_target_source,
                               {.method = options.method,
                                .first_distance = LastDistance(options, 2.0 * options.coarse_factor),
                                .last_distance = LastDistance(options, 3.0),
                                .max_iterations = options.max_iterations});
  Registration result;
  result.T_target_source = fine.T_target_source;
  result.converged = fine.converged;
  result.turned = start.turned;
  result.iterations = start.iterations + fine.iterations;
  result.covariance = CovarianceOf(fine, options.neighbours);
  Measure(source.fine, target.fine, options, result);
  return result;
}

double TiltOf(const Eigen::Isometry3d& T) { return std::acos(std::clamp(T.linear()(2, 2), -1.0, 1.0)); }

void Judge(const RegistrationOptions& options, Registration& result) {
  if (!result.converged) {
    result.reason = fmt::format("no convergence within {} steps", result.iterations);
  } else if (TiltOf(result.T_target_source) > options.max_tilt) {
    result.reason =
        fmt::format("tilted by {:.2f} rad: at most {} are possible", TiltOf(result.T_target_source), options.max_tilt);
  } else if (result.inlier_share < options.min_inlier_share) {
    result.reason =
        fmt::format("inlier share {:.3f}: at least {} is needed", result.inlier_share, options.min_inlier_share);
  } else if (!(result.fitness <= options.max_fitness)) {
    result.reason = fmt::format("fitness {:.3f} m^2: at most {} is allowed", result.fitness, options.max_fitness);
  } else {
    result.accepted = true;
    result.reason = fmt::format("inlier share {:.3f}, fitness {:.4f} m^2", result.inlier_share, result.fitness);
  }
}

Registration TooFew(const char* name, std::size_t points, const Eigen::Isometry3d& guess) {
  Registration result;
  result.T_target_source = guess;
  result.fitness = std::numeric_limits<double>::infinity();
  result.reason =
      fmt::format("the {} has {} points after thinning: at least {} are needed", name, points, kFewestPoints);
  return result;
}

}  // namespace

absl::Status Validate(const RegistrationOptions& options) {
  if (!(options.voxel > 0.0) || !(options.coarse_factor >= 1.0)) {
    return InvalidArgument("voxel {} and coarse_factor {}: expected positive metres and at least 1", options.voxel,
                           options.coarse_factor);
  }
  if (!(options.max_distance > 0.0) || !(options.inlier_distance > 0.0) || !(options.inlier_angle > 0.0)) {
    return InvalidArgument("max_distance {}, inlier_distance {} and inlier_angle {}: expected positive numbers",
                           options.max_distance, options.inlier_distance, options.inlier_angle);
  }
  if (options.max_iterations < 1 || options.neighbours < 4) {
    return InvalidArgument("max_iterations {} and neighbours {}: expected at least 1 and 4", options.max_iterations,
                           options.neighbours);
  }
  if (!(options.min_inlier_share >= 0.0 && options.min_inlier_share <= 1.0) || !(options.max_fitness > 0.0)) {
    return InvalidArgument("min_inlier_share {} and max_fitness {}: expected a share and positive m^2",
                           options.min_inlier_share, options.max_fitness);
  }
  const bool finite = std::all_of(options.yaw_offsets.begin(), options.yaw_offsets.end(),
                                  [](double offset) { return std::isfinite(offset); });
  if (options.yaw_offsets.empty() || !finite) return InvalidArgument("yaw_offsets: expected at least one, in rad");
  return absl::OkStatus();
}

absl::StatusOr<Registration> RegisterClouds(const Cloud& source, const Cloud& target,
                                            const Eigen::Isometry3d& T_target_source_guess,
                                            const RegistrationOptions& options) {
  ENFILADE_RETURN_IF_ERROR(Validate(options));
  if (!T_target_source_guess.matrix().allFinite()) return InvalidArgument("the initial guess is not finite");
  for (const auto& [cloud, name] : {std::pair{&source, "source"}, std::pair{&target, "target"}}) {
    ENFILADE_ASSIGN_OR_RETURN(const Cloud thinned, VoxelFilter(*cloud, options.voxel));
    if (thinned.points.size() < kFewestPoints) return TooFew(name, thinned.points.size(), T_target_source_guess);
  }
  ENFILADE_ASSIGN_OR_RETURN(const Levels source_levels, MakeLevels(source, options));
  ENFILADE_ASSIGN_OR_RETURN(const Levels target_levels, MakeLevels(target, options));
  std::vector<Start> starts = Coarse(source_levels, target_levels, T_target_source_guess, options);
  constexpr std::size_t kRefined = 2;
  if (starts.size() > kRefined) starts.resize(kRefined);
  Registration best = Refine(source_levels, target_levels, starts[0], options);
  if (starts.size() > 1) {
    Registration second = Refine(source_levels, target_levels, starts[1], options);
    if (ScoreOf(second) > ScoreOf(best)) best = std::move(second);
  }
  Judge(options, best);
  return best;
}

PoseWithCovariance PlanarPose(const Registration& registration) {
  const Eigen::Isometry3d& T = registration.T_target_source;
  PoseWithCovariance pose;
  pose.pose = {T.translation().x(), T.translation().y(), std::atan2(T.linear()(1, 0), T.linear()(0, 0))};
  constexpr int kKept[3] = {0, 1, 5};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      pose.covariance(row, column) = registration.covariance(kKept[row], kKept[column]);
    }
  }
  return pose;
}

PoseWithCovariance RobotInMap(const PoseWithCovariance& T_map_target, const Registration& registration) {
  return Compose(T_map_target, PlanarPose(registration));
}

}  // namespace enfilade::perception
