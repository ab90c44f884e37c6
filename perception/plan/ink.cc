// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "perception/plan/opencv_ink.h"

namespace enfilade::perception {
namespace {

cv::Mat Disk(int radius) { return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1}); }

double DiagonalOf(const cv::Mat& image) { return std::hypot(image.cols, image.rows); }

// The radius of what is too wide to be a wall: 1.2 % of the diagonal (1.2 m of wall in a building of 50 m).
constexpr double kWideShare = 0.012;

int WideRadius(const cv::Mat& image) {
  return std::max(3, static_cast<int>(std::lround(kWideShare * DiagonalOf(image))));
}

// Whether bright lines outweigh dark ones: by the thinnest structures that the sheet has enough of, as between wide
// walls, or many small rooms, what is not drawn is thin, too.
bool LinesAreBright(const cv::Mat& brightness) {
  const cv::Mat small = ShrunkTo(brightness, 1400);
  constexpr double kContrast = 64;
  constexpr double kEnough = 0.004;  // of the sheet
  int dark = 0, bright = 0;
  for (int radius = 1; radius <= 2 * WideRadius(small); radius = radius * 3 / 2 + 1) {
    cv::Mat thin;
    cv::morphologyEx(small, thin, cv::MORPH_BLACKHAT, Disk(radius));
    dark = cv::countNonZero(thin > kContrast);
    cv::morphologyEx(small, thin, cv::MORPH_TOPHAT, Disk(radius));
    bright = cv::countNonZero(thin > kContrast);
    if (std::max(dark, bright) > kEnough * static_cast<double>(small.total()) &&
        std::max(dark, bright) > 2 * std::min(dark, bright)) {
      break;
    }
  }
  return bright > dark;
}

// The paper's brightness where each pixel is, without the lines: a closing by a kernel far wider than walls.
cv::Mat PaperOf(const cv::Mat& brightness) {
  cv::Mat small = ShrunkTo(brightness, 500);
  const int radius = std::max(5, static_cast<int>(0.06 * DiagonalOf(small)));
  cv::Mat paper;
  cv::morphologyEx(small, paper, cv::MORPH_CLOSE, cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8U));
  cv::blur(paper, paper, {radius, radius});
  // Where everything is dark, it is the drawing and not the paper.
  double least = 0, most = 0;
  cv::minMaxLoc(paper, &least, &most);
  cv::max(paper, most * 0.5, paper);
  cv::resize(paper, paper, brightness.size(), 0, 0, cv::INTER_LINEAR);
  return paper;
}

// A grey between paper and ink that fills at least this share of the sheet evenly is an area of its own.
constexpr double kGreyShare = 0.05;

std::optional<int> EvenGrey(const cv::Mat& brightness) {
  cv::Mat high, low;
  cv::dilate(brightness, high, cv::Mat::ones(3, 3, CV_8U));
  cv::erode(brightness, low, cv::Mat::ones(3, 3, CV_8U));
  const cv::Mat even = (high - low) <= 3;
  std::array<int, 256> histogram{};
  for (int y = 0; y < brightness.rows; ++y) {
    for (int x = 0; x < brightness.cols; ++x) {
      if (even.at<uchar>(y, x)) ++histogram[brightness.at<uchar>(y, x)];
    }
  }
  const auto window = [&](int v) {
    int sum = 0;
    for (int i = std::max(0, v - 2); i <= std::min(255, v + 2); ++i) sum += histogram[i];
    return sum;
  };
  int paper = 255, best = -1;
  while (paper > 0 && window(paper) < kGreyShare * static_cast<double>(brightness.total())) --paper;
  for (int v = 60; v <= paper - 20; ++v) {
    if (best < 0 || window(v) > window(best)) best = v;
  }
  if (best < 0 || window(best) < kGreyShare * static_cast<double>(brightness.total())) return std::nullopt;
  return best;
}

// Otsu's threshold (1979) on the share of the paper's brightness, kept between plausible bounds.
cv::Mat DarkerThanPaper(const cv::Mat& brightness) {
  cv::Mat share;
  cv::divide(brightness, PaperOf(brightness), share, 255, CV_8U);
  cv::Mat ignored;
  const double otsu = cv::threshold(share, ignored, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  return share < std::clamp(otsu, 0.5 * 255, 0.8 * 255);
}

// Ink in a colour is dropped where most ink is not: routes, signs and grids over the plan.
void DropColours(const cv::Mat& colour, cv::Mat& ink) {
  if (colour.empty()) return;
  constexpr double kColourful = 60;
  const cv::Mat coloured = (colour > kColourful) & ink;
  const int all = cv::countNonZero(ink);
  if (2 * cv::countNonZero(coloured) < all) ink &= ~coloured;
}

cv::Mat LargePartsOf(const cv::Mat& mask, double smallest_area) {
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centres, 8);
  cv::Mat large = cv::Mat::zeros(mask.size(), CV_8U);
  std::vector<uchar> keep(count, 0);
  for (int i = 1; i < count; ++i) keep[i] = stats.at<int>(i, cv::CC_STAT_AREA) >= smallest_area ? 255 : 0;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) large.at<uchar>(y, x) = keep[labels.at<int>(y, x)];
  }
  return large;
}

}  // namespace

cv::Mat WidePartsOf(const cv::Mat& mask, double radius) {
  // Distances to the background. The sheet is mirrored at its border, so that what the border cuts off stays wide, and
  // a line along the border does not become so.
  const int margin = static_cast<int>(radius) + 2;
  cv::Mat distance;
  cv::copyMakeBorder(mask, distance, margin, margin, margin, margin, cv::BORDER_REFLECT);
  cv::distanceTransform(distance, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Mat core = distance > radius, away;
  cv::distanceTransform(~core, away, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  const cv::Mat opened = away <= radius + 0.75;
  return opened(cv::Rect(margin, margin, mask.cols, mask.rows)) & mask;
}

Ink FindInk(const Sheet& sheet) {
  cv::Mat brightness = sheet.brightness;
  if (LinesAreBright(brightness)) brightness = 255 - brightness;
  cv::Mat dark;
  if (const std::optional<int> grey = EvenGrey(brightness)) {
    dark = brightness <= *grey + 12;
    // Between an outline and the grey within it, smoothing leaves brighter pixels.
    cv::morphologyEx(dark, dark, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  } else {
    dark = DarkerThanPaper(brightness);
    DropColours(sheet.colour, dark);
  }
  Ink ink;
  const int radius = WideRadius(brightness);
  const cv::Mat wide = WidePartsOf(dark, radius);
  constexpr double kMassShare = 0.005;  // of the sheet; smaller wide parts are symbols
  ink.mass = LargePartsOf(wide, kMassShare * static_cast<double>(dark.total()));
  cv::Mat near_wide;
  cv::dilate(wide & ~ink.mass, near_wide, cv::Mat::ones(3, 3, CV_8U));
  ink.strokes = dark & ~ink.mass & ~near_wide;
  return ink;
}

}  // namespace enfilade::perception
