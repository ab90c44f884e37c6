// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "perception/plan/opencv_ink.h"
#include "perception/plan/opencv_thinning.h"

namespace enfilade::perception {
namespace {

// Paper between two lines that run beside each other.
struct Strip {
  int label = 0;
  double width = 0;   // px
  double length = 0;  // px
};

// The parts of the narrow paper that are long. Within a strip, the mean distance to the lines is (width + 2) / 4.
std::vector<Strip> StripsOf(const cv::Mat& labels, int count, const cv::Mat& distance) {
  std::vector<double> area(count, 0), sum(count, 0);
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      const int label = labels.at<int>(y, x);
      area[label] += 1;
      sum[label] += distance.at<float>(y, x);
    }
  }
  constexpr double kLongest = 3;  // times as long as wide
  std::vector<Strip> strips;
  for (int label = 1; label < count; ++label) {
    const double width = std::max(1.0, 4 * sum[label] / area[label] - 2);
    if (area[label] / width >= kLongest * width) strips.push_back({label, width, area[label] / width});
  }
  return strips;
}

bool IsAsWideAs(const Strip& strip, double width) { return strip.width >= 0.7 * width && strip.width <= 1.4 * width; }

double LengthOfWidth(const std::vector<Strip>& strips, double width) {
  double length = 0;
  for (const Strip& strip : strips) length += IsAsWideAs(strip, width) ? strip.length : 0;
  return length;
}

}  // namespace

void FillDoubleLines(Ink& ink) {
  const cv::Mat drawn = ink.strokes | ink.mass;
  const double widest = 0.008 * std::hypot(drawn.cols, drawn.rows);  // half of the largest gap, px
  const cv::Mat paper = ~drawn;
  const cv::Mat narrow = paper & ~WidePartsOf(paper, widest);
  cv::Mat distance, labels;
  cv::distanceTransform(paper, distance, cv::DIST_L2, cv::DIST_MASK_5);
  const int count = cv::connectedComponents(narrow, labels, 4);
  std::vector<Strip> strips = StripsOf(labels, count, distance);
  const double lines = cv::countNonZero(Thin(ink.strokes));
  std::vector<uchar> fill(count, 0);
  // Walls of one style have one or two thicknesses; what else lies between lines has many.
  constexpr double kFirstShare = 0.5, kNextShare = 0.12;  // of the lines' length
  for (double share = kFirstShare; !strips.empty(); share = kNextShare) {
    const auto usual = std::max_element(strips.begin(), strips.end(), [&](const Strip& a, const Strip& b) {
      return LengthOfWidth(strips, a.width) < LengthOfWidth(strips, b.width);
    });
    const double width = usual->width;
    if (2 * LengthOfWidth(strips, width) < share * lines) break;
    for (const Strip& strip : strips) fill[strip.label] |= IsAsWideAs(strip, width) ? 255 : 0;
    std::erase_if(strips, [&](const Strip& strip) { return IsAsWideAs(strip, width); });
  }
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      if (fill[labels.at<int>(y, x)] != 0) ink.strokes.at<uchar>(y, x) = 255;
    }
  }
}

}  // namespace enfilade::perception
