// SPDX-License-Identifier: Apache-2.0
#include "perception/environment/frame_similarity.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/base/environment.h"
#include "core/base/status_macros.h"
#include "perception/image/opencv_guard.h"

namespace enfilade::perception {
namespace {

constexpr double kPeak = 255.0;
constexpr double kC1 = 6.5025;   // (0.01 * 255)^2
constexpr double kC2 = 58.5225;  // (0.03 * 255)^2

absl::Status CheckPair(const GreyFrame& a, const GreyFrame& b) {
  ENFILADE_RETURN_IF_ERROR(Validate(a));
  ENFILADE_RETURN_IF_ERROR(Validate(b));
  if (a.width != b.width || a.height != b.height) {
    return InvalidArgument("images of {}x{} and {}x{} pixels cannot be compared", a.width, a.height, b.width, b.height);
  }
  return absl::OkStatus();
}

cv::Mat ToFloat(const GreyFrame& frame) {
  const cv::Mat grey(frame.height, frame.width, CV_8U, const_cast<std::uint8_t*>(frame.pixels.data()));
  cv::Mat real;
  grey.convertTo(real, CV_64F);
  return real;
}

cv::Mat Blurred(const cv::Mat& image) {
  cv::Mat blurred;
  cv::GaussianBlur(image, blurred, cv::Size(11, 11), 1.5);
  return blurred;
}

}  // namespace

absl::StatusOr<double> StructuralSimilarity(const GreyFrame& a, const GreyFrame& b) {
  ENFILADE_RETURN_IF_ERROR(CheckPair(a, b));
  return GuardOpenCv("comparing images", [&]() -> absl::StatusOr<double> {
    const cv::Mat x = ToFloat(a);
    const cv::Mat y = ToFloat(b);
    const cv::Mat mean_x = Blurred(x);
    const cv::Mat mean_y = Blurred(y);
    const cv::Mat mean_xx = mean_x.mul(mean_x);
    const cv::Mat mean_yy = mean_y.mul(mean_y);
    const cv::Mat mean_xy = mean_x.mul(mean_y);
    const cv::Mat variance_x = Blurred(x.mul(x)) - mean_xx;
    const cv::Mat variance_y = Blurred(y.mul(y)) - mean_yy;
    const cv::Mat covariance = Blurred(x.mul(y)) - mean_xy;
    const cv::Mat above = cv::Mat(2.0 * mean_xy + kC1).mul(cv::Mat(2.0 * covariance + kC2));
    const cv::Mat below = cv::Mat(mean_xx + mean_yy + kC1).mul(cv::Mat(variance_x + variance_y + kC2));
    return cv::mean(above / below)[0];
  });
}

absl::StatusOr<double> PeakSignalToNoise(const GreyFrame& a, const GreyFrame& b) {
  ENFILADE_RETURN_IF_ERROR(CheckPair(a, b));
  double sum = 0.0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double difference = static_cast<double>(a.pixels[i]) - static_cast<double>(b.pixels[i]);
    sum += difference * difference;
  }
  if (sum == 0.0) return std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(kPeak * kPeak * static_cast<double>(a.pixels.size()) / sum);
}

GreyFrame BrightnessOf(const DepthFrame& frame, double max_depth) {
  GreyFrame grey{frame.width, frame.height, {}};
  grey.pixels.reserve(frame.metres.size());
  for (const float depth : frame.metres) {
    const bool measured = std::isfinite(depth) && depth > 0.0F;
    const double share = measured ? std::min(1.0, static_cast<double>(depth) / max_depth) : 0.0;
    grey.pixels.push_back(static_cast<std::uint8_t>(std::lround(kPeak * share)));
  }
  return grey;
}

absl::Status Validate(const SimilarityCriterion& criterion) {
  if (!std::isfinite(criterion.threshold) || criterion.frames < 2 || !(criterion.max_depth > 0.0)) {
    return InvalidArgument(
        "similarity criterion: threshold {}, {} frames, {} m: expected a number, at least 2 and a "
        "positive depth",
        criterion.threshold, criterion.frames, criterion.max_depth);
  }
  return absl::OkStatus();
}

absl::StatusOr<SimilarityChoice> ChooseBySimilarity(std::span<const DepthFrame> frames,
                                                    const SimilarityCriterion& criterion) {
  ENFILADE_RETURN_IF_ERROR(Validate(criterion));
  const std::size_t count = std::min(frames.size(), static_cast<std::size_t>(criterion.frames));
  if (count < 2) return InvalidArgument("{} depth images: at least 2 are needed to compare", frames.size());
  SimilarityChoice choice;
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) ENFILADE_RETURN_IF_ERROR(Validate(frames[i]));
  GreyFrame last = BrightnessOf(frames[0], criterion.max_depth);
  for (std::size_t i = 1; i < count; ++i) {
    GreyFrame next = BrightnessOf(frames[i], criterion.max_depth);
    ENFILADE_ASSIGN_OR_RETURN(const double value, criterion.measure == SimilarityMeasure::kSsim
                                                      ? StructuralSimilarity(last, next)
                                                      : PeakSignalToNoise(last, next));
    sum += value;
    ++choice.pairs;
    last = std::move(next);
  }
  choice.mean = sum / choice.pairs;
  choice.environment = choice.mean < criterion.threshold ? Environment::kOutdoor : Environment::kIndoor;
  return choice;
}

}  // namespace enfilade::perception
