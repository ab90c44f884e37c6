// SPDX-License-Identifier: Apache-2.0
#include "perception/image/features.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "core/base/status_macros.h"
#include "perception/image/opencv_guard.h"

namespace enfilade::perception {
namespace {

constexpr int kSmallestSide = 32;  // AKAZE's pyramid needs at least this

struct Detected {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
};

Detected DetectSift(const cv::Mat& grey, const FeatureOptions& options) {
  Detected detected;
  cv::SIFT::create(0, 3, options.sift_contrast, 10.0, 1.6, CV_8U)
      ->detectAndCompute(grey, cv::noArray(), detected.keypoints, detected.descriptors);
  return detected;
}

Detected DetectAkaze(const cv::Mat& grey, const FeatureOptions& options) {
  Detected detected;
  cv::AKAZE::create(cv::AKAZE::DESCRIPTOR_MLDB, 0, 3, static_cast<float>(options.akaze_threshold))
      ->detectAndCompute(grey, cv::noArray(), detected.keypoints, detected.descriptors);
  return detected;
}

// The strongest keypoints in a deterministic order: multi-threaded detectors return them in any order.
std::vector<int> Strongest(const std::vector<cv::KeyPoint>& keypoints, int most) {
  std::vector<int> order(keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int i) {
    const cv::KeyPoint& k = keypoints[static_cast<std::size_t>(i)];
    return std::tuple(-k.response, k.pt.x, k.pt.y, k.size, k.angle);
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  if (order.size() > static_cast<std::size_t>(most)) order.resize(static_cast<std::size_t>(most));
  return order;
}

void Append(const Detected& detected, const FeatureOptions& options, double scale, std::vector<Keypoint>& keypoints,
            std::vector<std::uint8_t>& descriptors) {
  for (const int i : Strongest(detected.keypoints, options.max_features)) {
    const cv::KeyPoint& found = detected.keypoints[static_cast<std::size_t>(i)];
    const auto factor = static_cast<float>(scale);
    // Pixel centres are at whole numbers before and after scaling.
    keypoints.push_back({.x = (found.pt.x + 0.5F) * factor - 0.5F,
                         .y = (found.pt.y + 0.5F) * factor - 0.5F,
                         .size = found.size * factor,
                         .angle = found.angle * std::numbers::pi_v<float> / 180.0F});
    const auto* row = detected.descriptors.ptr<std::uint8_t>(i);
    descriptors.insert(descriptors.end(), row, row + detected.descriptors.cols);
  }
}

}  // namespace

absl::Status Validate(const FeatureOptions& options) {
  if (options.max_side < kSmallestSide) {
    return InvalidArgument("max_side is {}: expected at least {} pixels", options.max_side, kSmallestSide);
  }
  if (options.max_features < 1) return InvalidArgument("max_features is {}: expected at least 1", options.max_features);
  if (!(options.sift_contrast >= 0.0) || !(options.akaze_threshold > 0.0)) {
    return InvalidArgument("sift_contrast {} and akaze_threshold {}: expected positive numbers", options.sift_contrast,
                           options.akaze_threshold);
  }
  return absl::OkStatus();
}

absl::StatusOr<FeatureSet> ExtractFeatures(const GreyFrame& frame, const FeatureOptions& options) {
  ENFILADE_RETURN_IF_ERROR(Validate(frame));
  ENFILADE_RETURN_IF_ERROR(Validate(options));
  FeatureSet features;
  features.width = frame.width;
  features.height = frame.height;
  if (std::min(frame.width, frame.height) < kSmallestSide) return features;
  return GuardOpenCv("extracting features", [&]() -> absl::StatusOr<FeatureSet> {
    cv::Mat grey(frame.height, frame.width, CV_8U, const_cast<std::uint8_t*>(frame.pixels.data()));
    const int longer = std::max(frame.width, frame.height);
    double scale = 1.0;
    if (longer > options.max_side) {
      scale = static_cast<double>(longer) / options.max_side;
      const cv::Size size(static_cast<int>(std::lround(frame.width / scale)),
                          static_cast<int>(std::lround(frame.height / scale)));
      if (std::min(size.width, size.height) < kSmallestSide) return features;
      cv::Mat smaller;
      cv::resize(grey, smaller, size, 0.0, 0.0, cv::INTER_AREA);
      grey = smaller;
    }
    Detected sift;
    Detected akaze;
    // OpenCV's pool runs both in parallel if it has threads, and starts none within them.
    cv::parallel_for_(cv::Range(0, 2), [&](const cv::Range& range) {
      if (range.start == 0) sift = DetectSift(grey, options);
      if (range.end == 2) akaze = DetectAkaze(grey, options);
    });
    Append(sift, options, scale, features.sift, features.sift_descriptors);
    Append(akaze, options, scale, features.akaze, features.akaze_descriptors);
    return features;
  });
}

}  // namespace enfilade::perception
