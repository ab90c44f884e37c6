// SPDX-License-Identifier: Apache-2.0
#include "perception/image/geometric_verification.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "core/base/status_macros.h"
#include "perception/image/opencv_guard.h"

namespace enfilade::perception {
namespace {

cv::UsacParams RansacOf(double tolerance, std::uint32_t seed) {
  cv::UsacParams params;
  params.confidence = 0.999;
  params.isParallel = false;  // threads would make the result depend on their timing
  params.loMethod = cv::LOCAL_OPTIM_INNER_LO;
  params.maxIterations = 2000;
  params.randomGeneratorState = static_cast<int>(seed & 0x7fffffffU);
  params.sampler = cv::SAMPLING_UNIFORM;
  params.score = cv::SCORE_METHOD_MSAC;
  params.threshold = tolerance;
  return params;
}

struct Points {
  std::vector<cv::Point2f> a;
  std::vector<cv::Point2f> b;
};

Points PointsOf(const std::vector<TentativeMatch>& matches, const std::vector<std::size_t>& subset) {
  Points points;
  for (const std::size_t i : subset) {
    points.a.emplace_back(matches[i].a.x(), matches[i].a.y());
    points.b.emplace_back(matches[i].b.x(), matches[i].b.y());
  }
  return points;
}

// A homography's Jacobian at a point, taken as a rotation with scale.
struct LocalChange {
  double octaves = 0.0;  // log2 of the scale
  double rotation = 0.0;
};

// Nothing for mirror images and points behind the camera.
std::optional<LocalChange> LocalChangeAt(const cv::Matx33d& H, const Eigen::Vector2f& at) {
  const cv::Vec3d p = H * cv::Vec3d(at.x(), at.y(), 1.0);
  if (!(p[2] * H(2, 2) > 0.0)) return std::nullopt;
  const double u = p[0] / p[2];
  const double v = p[1] / p[2];
  const double dudx = (H(0, 0) - H(2, 0) * u) / p[2];
  const double dudy = (H(0, 1) - H(2, 1) * u) / p[2];
  const double dvdx = (H(1, 0) - H(2, 0) * v) / p[2];
  const double dvdy = (H(1, 1) - H(2, 1) * v) / p[2];
  const double determinant = dudx * dvdy - dudy * dvdx;
  if (!(determinant > 0.0)) return std::nullopt;
  return LocalChange{0.5 * std::log2(determinant), std::atan2(dvdx - dudy, dudx + dvdy)};
}

// Whether the change in size and direction between a match's keypoints agrees with the homography there.
bool AgreesLocally(const std::optional<LocalChange>& change, const TentativeMatch& match,
                   const ImageMatchOptions& options) {
  return change && std::abs(match.octaves - change->octaves) < options.size_tolerance &&
         std::abs(std::remainder(match.rotation - change->rotation, 2.0 * std::numbers::pi)) < options.angle_tolerance;
}

Eigen::Matrix3d ToEigen(const cv::Matx33d& matrix) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.val);
}

Verification VerifyPlanes(const std::vector<TentativeMatch>& matches, double tolerance_px,
                          const ImageMatchOptions& options) {
  Verification found{std::vector<char>(matches.size(), 0), std::vector<float>(matches.size(), 0.0F), std::nullopt};
  std::vector<std::size_t> left(matches.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  for (int plane = 0; plane < options.max_planes && left.size() >= 4; ++plane) {
    const Points points = PointsOf(matches, left);
    cv::Mat mask;
    const cv::Mat H = cv::findHomography(points.a, points.b, mask,
                                         RansacOf(tolerance_px, options.seed + static_cast<std::uint32_t>(plane)));
    if (H.empty()) break;
    const cv::Matx33d H_b_a(H);
    std::vector<std::size_t> of_plane;
    std::vector<std::size_t> others;
    for (std::size_t k = 0; k < left.size(); ++k) {
      const std::optional<LocalChange> change = LocalChangeAt(H_b_a, matches[left[k]].a);
      const bool fits =
          mask.at<std::uint8_t>(static_cast<int>(k)) != 0 && AgreesLocally(change, matches[left[k]], options);
      (fits ? of_plane : others).push_back(left[k]);
      if (fits) found.octaves[left[k]] = static_cast<float>(change->octaves);
    }
    if (plane > 0 && of_plane.size() < static_cast<std::size_t>(options.min_plane_inliers)) break;
    for (const std::size_t i : of_plane) found.is_inlier[i] = 1;
    if (plane == 0) found.H_b_a = ToEigen(H_b_a);
    left = std::move(others);
  }
  return found;
}

cv::Matx33d MatrixOf(const Intrinsics& k) { return {k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0}; }

Verification VerifyEpipolar(const std::vector<TentativeMatch>& matches, double tolerance_px,
                            const ImageMatchOptions& options) {
  Verification found{std::vector<char>(matches.size(), 0), std::vector<float>(matches.size(), 0.0F), std::nullopt};
  if (matches.size() < 8) return found;
  std::vector<std::size_t> all(matches.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  const Points points = PointsOf(matches, all);
  const cv::UsacParams ransac = RansacOf(tolerance_px, options.seed);
  cv::Mat mask;
  cv::Mat model;
  if (options.model == GeometricModel::kEssential) {
    model = cv::findEssentialMat(points.a, points.b, MatrixOf(*options.intrinsics_a), MatrixOf(*options.intrinsics_b),
                                 cv::noArray(), cv::noArray(), mask, ransac);
  } else {
    model = cv::findFundamentalMat(points.a, points.b, mask, ransac);
  }
  if (model.empty() || mask.total() != matches.size()) return found;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (mask.at<std::uint8_t>(static_cast<int>(i)) == 0) continue;
    found.is_inlier[i] = 1;
    found.octaves[i] = matches[i].octaves;
  }
  return found;
}

}  // namespace

absl::StatusOr<Verification> VerifyGeometry(const std::vector<TentativeMatch>& matches, double tolerance_px,
                                            const ImageMatchOptions& options) {
  if (options.model == GeometricModel::kNone) {
    return Verification{std::vector<char>(matches.size(), 1), std::vector<float>(matches.size(), 0.0F), std::nullopt};
  }
  return GuardOpenCv("verifying matches", [&]() -> absl::StatusOr<Verification> {
    return options.model == GeometricModel::kPlanes ? VerifyPlanes(matches, tolerance_px, options)
                                                    : VerifyEpipolar(matches, tolerance_px, options);
  });
}

}  // namespace enfilade::perception
