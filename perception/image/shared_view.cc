// SPDX-License-Identifier: Apache-2.0
#include "perception/image/shared_view.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace enfilade::perception {
namespace {

constexpr int kColumns = 8;
constexpr int kRows = 6;
constexpr int kLeastFeatures = 3;  // of a cell that counts

// Of a line through magnifications over distances from the centre: the least slope and value at the centre that
// contradict each other.
constexpr double kFarMagnified = 0.1;
constexpr double kNearNotMagnified = -0.15;

using Cells = std::array<int, kColumns * kRows>;

void Count(float x, float y, const FeatureSet& image, Cells& cells) {
  const int column = std::clamp(static_cast<int>(x * kColumns / static_cast<float>(image.width)), 0, kColumns - 1);
  const int row = std::clamp(static_cast<int>(y * kRows / static_cast<float>(image.height)), 0, kRows - 1);
  ++cells[static_cast<std::size_t>(row * kColumns + column)];
}

double MeanShare(const FeatureSet& image, const Cells& matched, const FeatureSet& other,
                 const std::optional<Eigen::Matrix3d>& H_other_image) {
  Cells all{};
  for (const std::vector<Keypoint>* keypoints : {&image.sift, &image.akaze}) {
    for (const Keypoint& keypoint : *keypoints) {
      if (!H_other_image || IsShownIn(other, *H_other_image, keypoint)) Count(keypoint.x, keypoint.y, image, all);
    }
  }
  double sum = 0.0;
  int counted = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i] < kLeastFeatures) continue;
    sum += std::min(1.0, static_cast<double>(matched[i]) / all[i]);
    ++counted;
  }
  return counted > 0 ? sum / counted : 0.0;
}

// The camera must have moved ahead from image a to `to`: of the view that is nearer, magnification - 1 = d / Z, and 1 /
// Z grows with the distance from the focus of expansion for walls, floor and ceiling along the way. Fits value at the
// centre, slope, and what a turn or a step aside adds.
bool AgreesAhead(const std::vector<PointPair>& pairs, bool swapped, const FeatureSet& to) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  const double half = to.width / 2.0;
  double count = 0.0;
  for (const PointPair& pair : pairs) {
    if (!pair.is_inlier) continue;
    const Eigen::Vector2f& at = swapped ? pair.a : pair.b;
    const double x = (at.x() - half) / half;
    const double y = (at.y() - to.height / 2.0) / half;
    const Eigen::Vector4d row(1.0, std::hypot(x, y), x, y);
    A += row * row.transpose();
    b += row * (std::exp2(swapped ? -pair.octaves : pair.octaves) - 1.0);
    count += 1.0;
  }
  A.diagonal().array() += 1e-3 * count;  // inliers on a line leave the rest open: then no trend
  const Eigen::Vector4d fit = A.ldlt().solve(b);
  return !(fit(0) > kFarMagnified && fit(1) < kNearNotMagnified);
}

}  // namespace

bool IsShownIn(const FeatureSet& b, const Eigen::Matrix3d& H_b_a, const Keypoint& in_a) {
  const Eigen::Vector3d p = H_b_a * Eigen::Vector3d(in_a.x, in_a.y, 1.0);
  const double x = p.x() / p.z();
  const double y = p.y() / p.z();
  return x >= 0.0 && y >= 0.0 && x < b.width && y < b.height;  // false for NaN
}

SharedView CompareViews(const FeatureSet& a, const FeatureSet& b, const std::vector<PointPair>& pairs,
                        const std::optional<Eigen::Matrix3d>& H_b_a, double max_octaves) {
  Cells in_a{};
  Cells in_b{};
  double octaves = 0.0;
  Eigen::Vector2f shift = Eigen::Vector2f::Zero();
  int inliers = 0;
  for (const PointPair& pair : pairs) {
    if (!pair.is_inlier) continue;
    ++inliers;
    octaves += pair.octaves;
    shift += pair.b - pair.a;
    if (std::abs(pair.octaves) > max_octaves) continue;
    Count(pair.a.x(), pair.a.y(), a, in_a);
    Count(pair.b.x(), pair.b.y(), b, in_b);
  }
  SharedView view;
  if (inliers == 0) return view;
  view.shift = shift.norm() / static_cast<float>(inliers * std::max(b.width, b.height));
  std::optional<Eigen::Matrix3d> H_a_b;
  if (H_b_a) H_a_b = H_b_a->inverse();
  view.share = std::min(MeanShare(a, in_a, b, H_b_a), MeanShare(b, in_b, a, H_a_b));
  const bool swapped = octaves < 0.0;
  view.parallax_agrees = AgreesAhead(pairs, swapped, swapped ? a : b);
  return view;
}

}  // namespace enfilade::perception
