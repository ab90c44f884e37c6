// SPDX-License-Identifier: Apache-2.0
#include "perception/image/match_images.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "perception/image/geometric_verification.h"
#include "perception/image/shared_view.h"

namespace enfilade::perception {
namespace {

constexpr float kSameSpotPx = 2.0F;  // closer matches in both images count as one

absl::Status Validate(const FeatureSet& features, const char* name) {
  if (features.sift_descriptors.size() != features.sift.size() * kSiftBytes ||
      features.akaze_descriptors.size() != features.akaze.size() * kAkazeBytes) {
    return InvalidArgument("features of image {}: different numbers of descriptors and keypoints", name);
  }
  return absl::OkStatus();
}

void Append(const std::vector<Keypoint>& keypoints_a, const std::vector<Keypoint>& keypoints_b,
            const std::vector<DescriptorMatch>& found, std::vector<TentativeMatch>& matches) {
  for (const DescriptorMatch& match : found) {
    const Keypoint& a = keypoints_a[static_cast<std::size_t>(match.a)];
    const Keypoint& b = keypoints_b[static_cast<std::size_t>(match.b)];
    const TentativeMatch tentative{{a.x, a.y}, {b.x, b.y}, std::log2(b.size / a.size), b.angle - a.angle};
    const bool known = std::any_of(matches.begin(), matches.end(), [&](const TentativeMatch& other) {
      return (other.a - tentative.a).norm() < kSameSpotPx && (other.b - tentative.b).norm() < kSameSpotPx;
    });
    if (!known) matches.push_back(tentative);
  }
}

int CountShown(const FeatureSet& image, const FeatureSet& other, const Eigen::Matrix3d& H_other_image) {
  const auto is_shown = [&](const Keypoint& keypoint) { return IsShownIn(other, H_other_image, keypoint); };
  return static_cast<int>(std::count_if(image.sift.begin(), image.sift.end(), is_shown) +
                          std::count_if(image.akaze.begin(), image.akaze.end(), is_shown));
}

// Features in the part that both images show by the plane's homography, in the image with fewer of them.
int CountOverlap(const FeatureSet& a, const FeatureSet& b, const std::optional<Eigen::Matrix3d>& H_b_a) {
  if (!H_b_a) return static_cast<int>(std::min(a.sift.size() + a.akaze.size(), b.sift.size() + b.akaze.size()));
  return std::min(CountShown(a, b, *H_b_a), CountShown(b, a, H_b_a->inverse()));
}

std::string ReasonOf(const ImageMatch& match, const ImageMatchOptions& options) {
  if (match.accepted) return fmt::format("{} inliers, more than {}", match.inliers, options.threshold);
  if (match.other_place) {
    return fmt::format("same view, other place: {} inliers, but {}", match.inliers,
                       match.view_share > options.min_view_share
                           ? "what is near does not move as it does before a camera that moves"
                           : "too few of what is near");
  }
  const int fewest = std::min(match.features_a, match.features_b);
  if (fewest <= options.threshold) {
    return fmt::format("image {} has too little texture: {} features", match.features_a == fewest ? "A" : "B", fewest);
  }
  if (match.matches <= options.threshold) {
    return fmt::format("{} matches: more than {} are needed", match.matches, options.threshold);
  }
  if (match.inliers > options.threshold) {
    return fmt::format("{} inliers of {} features that both images should show: more than {:.0f} % are needed",
                       match.inliers, match.overlap, 100.0 * options.min_share);
  }
  return fmt::format("{} of {} matches agree on a geometry: more than {} are needed", match.inliers, match.matches,
                     options.threshold);
}

void Judge(const FeatureSet& a, const FeatureSet& b, const std::optional<Eigen::Matrix3d>& H_b_a,
           const ImageMatchOptions& options, ImageMatch& match) {
  match.accepted = match.inliers > options.threshold && match.inliers > options.min_share * match.overlap;
  if (!match.accepted || options.min_view_share <= 0.0) return;
  const SharedView view = CompareViews(a, b, match.pairs, H_b_a, options.max_octaves);
  match.view_share = view.share;
  if (view.shift > options.max_shift) return;
  match.other_place = view.share <= options.min_view_share || !view.parallax_agrees;
  match.accepted = !match.other_place;
}

}  // namespace

ImageMatchOptions MapManagerImageMatchOptions() {
  ImageMatchOptions options;
  options.model = GeometricModel::kNone;
  options.threshold = 30;
  options.min_share = 0.0;
  options.min_view_share = 0.0;
  return options;
}

absl::Status Validate(const ImageMatchOptions& options) {
  const auto is_ratio = [](double ratio) { return ratio > 0.0 && ratio <= 1.0; };
  if (!is_ratio(options.ratios.sift) || !is_ratio(options.ratios.akaze)) {
    return InvalidArgument("ratios {} (SIFT) and {} (AKAZE): expected numbers above 0, at most 1", options.ratios.sift,
                           options.ratios.akaze);
  }
  if (!(options.tolerance > 0.0 && options.tolerance < 1.0)) {
    return InvalidArgument("tolerance is {}: expected a share of the image's longer side", options.tolerance);
  }
  if (!(options.size_tolerance > 0.0) || !(options.angle_tolerance > 0.0)) {
    return InvalidArgument("size_tolerance {} and angle_tolerance {}: expected positive numbers",
                           options.size_tolerance, options.angle_tolerance);
  }
  if (options.max_planes < 1 || options.min_plane_inliers < 4) {
    return InvalidArgument("max_planes {} and min_plane_inliers {}: expected at least 1 and 4", options.max_planes,
                           options.min_plane_inliers);
  }
  if (options.threshold < 0) return InvalidArgument("threshold is {}: expected at least 0", options.threshold);
  if (!(options.min_share >= 0.0 && options.min_share < 1.0)) {
    return InvalidArgument("min_share is {}: expected a share below 1", options.min_share);
  }
  if (!(options.min_view_share >= 0.0 && options.min_view_share < 1.0) || !(options.max_octaves > 0.0) ||
      !(options.max_shift >= 0.0)) {
    return InvalidArgument(
        "min_view_share {}, max_octaves {} and max_shift {}: expected a share below 1, a positive "
        "number, and one that is not negative",
        options.min_view_share, options.max_octaves, options.max_shift);
  }
  if (options.model == GeometricModel::kEssential) {
    for (const auto& camera : {options.intrinsics_a, options.intrinsics_b}) {
      if (!camera || !(camera->fx > 0.0) || !(camera->fy > 0.0) || !std::isfinite(camera->cx + camera->cy)) {
        return InvalidArgument("the essential matrix needs the intrinsics of both cameras");
      }
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<ImageMatch> MatchImages(const FeatureSet& a, const FeatureSet& b, const ImageMatchOptions& options) {
  ENFILADE_RETURN_IF_ERROR(Validate(options));
  ENFILADE_RETURN_IF_ERROR(Validate(a, "A"));
  ENFILADE_RETURN_IF_ERROR(Validate(b, "B"));
  std::vector<TentativeMatch> matches;
  Append(a.sift, b.sift, MatchSift(a, b, options.ratios), matches);
  Append(a.akaze, b.akaze, MatchAkaze(a, b, options.ratios), matches);
  const double tolerance_px = options.tolerance * std::max(b.width, b.height);
  ENFILADE_ASSIGN_OR_RETURN(const Verification verified, VerifyGeometry(matches, tolerance_px, options));
  const std::vector<char>& inliers = verified.is_inlier;

  ImageMatch result;
  result.features_a = static_cast<int>(a.sift.size() + a.akaze.size());
  result.features_b = static_cast<int>(b.sift.size() + b.akaze.size());
  result.matches = static_cast<int>(matches.size());
  result.inliers = static_cast<int>(std::count(inliers.begin(), inliers.end(), 1));
  result.overlap = CountOverlap(a, b, verified.H_b_a);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    result.pairs.push_back({matches[i].a, matches[i].b, inliers[i] != 0, verified.octaves[i]});
  }
  Judge(a, b, verified.H_b_a, options, result);
  result.reason = ReasonOf(result, options);
  return result;
}

}  // namespace enfilade::perception
