// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "perception/plan/opencv_sheet.h"
#include "perception/plan/walls/stroke_graph.h"

namespace enfilade::perception {
namespace {

using Outline = std::vector<cv::Point>;
using Quadrilateral = std::array<cv::Point2d, 4>;  // clockwise from the corner nearest to the upper left

constexpr double kSearchDiagonal = 1600;  // px

// What is brighter than the rest of the picture, without the ink: its largest part's outline.
Outline BrightestArea(const cv::Mat& small, double& threshold) {
  cv::Mat smooth, mask;
  cv::GaussianBlur(small, smooth, {5, 5}, 0);
  const int radius = std::max(3, static_cast<int>(0.012 * std::hypot(small.cols, small.rows)));
  const cv::Mat disk = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
  cv::morphologyEx(smooth, smooth, cv::MORPH_CLOSE, disk);
  threshold = cv::threshold(smooth, mask, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, disk);
  std::vector<Outline> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  if (outlines.empty()) return {};
  return *std::max_element(outlines.begin(), outlines.end(),
                           [](const Outline& a, const Outline& b) { return cv::contourArea(a) < cv::contourArea(b); });
}

bool LiesWithin(const Outline& outline, const cv::Size& picture) {
  constexpr int kMargin = 2;
  return std::all_of(outline.begin(), outline.end(), [&](const cv::Point& p) {
    return p.x >= kMargin && p.y >= kMargin && p.x < picture.width - kMargin && p.y < picture.height - kMargin;
  });
}

std::optional<Outline> FourCornersOf(const Outline& outline) {
  Outline hull, corners;
  cv::convexHull(outline, hull);
  constexpr double kLeastFilled = 0.96;
  if (cv::contourArea(outline) < kLeastFilled * cv::contourArea(hull)) return std::nullopt;
  const double length = cv::arcLength(hull, true);
  for (double tolerance = 0.01; tolerance < 0.06 && corners.size() != 4; tolerance += 0.005) {
    cv::approxPolyDP(hull, corners, tolerance * length, true);
  }
  if (corners.size() != 4) return std::nullopt;
  return corners;
}

// The line along the outline between two of its corners; nullopt: it is not straight.
std::optional<FittedLine> SideBetween(const Outline& outline, const cv::Point2d& from, const cv::Point2d& to) {
  const cv::Point2d along = to - from;
  const double length = std::hypot(along.x, along.y);
  Moments moments;
  for (const cv::Point& point : outline) {
    const cv::Point2d offset = cv::Point2d(point) - from;
    const double share = offset.dot(along) / (length * length);
    const double aside = std::abs(offset.cross(along)) / length;
    if (share > 0.08 && share < 0.92 && aside < 0.03 * length) moments.Add({point.x, point.y});
  }
  constexpr double kLeastPoints = 0.7, kStraight = 0.004;  // of the length
  if (moments.count < kLeastPoints * length * 0.7) return std::nullopt;
  FittedLine line = FitLine(moments);
  if (line.rms > std::max(1.0, kStraight * length)) return std::nullopt;
  return line;
}

std::optional<cv::Point2d> Intersection(const FittedLine& a, const FittedLine& b) {
  const double turn = a.normal.x() * b.normal.y() - a.normal.y() * b.normal.x();
  if (std::abs(turn) < 0.5) return std::nullopt;  // a page's corner is seen at 30 to 150 degrees
  return cv::Point2d((a.offset * b.normal.y() - b.offset * a.normal.y()) / turn,
                     (b.offset * a.normal.x() - a.offset * b.normal.x()) / turn);
}

std::optional<Quadrilateral> FitQuadrilateral(const Outline& outline, const Outline& corners) {
  std::array<FittedLine, 4> sides;
  for (int i = 0; i < 4; ++i) {
    const std::optional<FittedLine> side = SideBetween(outline, corners[i], corners[(i + 1) % 4]);
    if (!side) return std::nullopt;
    sides[i] = *side;
  }
  std::vector<cv::Point2d> fitted;
  for (int i = 0; i < 4; ++i) {
    const std::optional<cv::Point2d> corner = Intersection(sides[(i + 3) % 4], sides[i]);
    if (!corner) return std::nullopt;
    fitted.push_back(*corner);
  }
  const auto area = [&] {
    double sum = 0;
    for (int i = 0; i < 4; ++i) sum += fitted[i].cross(fitted[(i + 1) % 4]) / 2;
    return sum;
  };
  if (area() < 0) std::reverse(fitted.begin(), fitted.end());  // clockwise as y points down
  if (std::abs(area() - cv::contourArea(outline)) > 0.03 * area()) return std::nullopt;
  const auto first = std::min_element(fitted.begin(), fitted.end(),
                                      [](const cv::Point2d& a, const cv::Point2d& b) { return a.x + a.y < b.x + b.y; });
  std::rotate(fitted.begin(), first, fitted.end());
  Quadrilateral quadrilateral;
  std::copy(fitted.begin(), fitted.end(), quadrilateral.begin());
  return quadrilateral;
}

// Beside every side it is bright within and darker outside.
bool StandsOut(const cv::Mat& small, const Quadrilateral& page, double threshold) {
  constexpr double kContrast = 20, kMostInk = 0.25;
  const double reach = 0.006 * std::hypot(small.cols, small.rows);
  for (int i = 0; i < 4; ++i) {
    const cv::Point2d from = page[i], along = page[(i + 1) % 4] - page[i];
    const cv::Point2d inwards = cv::Point2d(-along.y, along.x) * (reach / std::hypot(along.x, along.y));
    double within = 0, outside = 0, ink = 0;
    int count = 0;
    for (double share = 0.05; share <= 0.95; share += 0.005) {
      const cv::Point2d p = from + share * along;
      const cv::Point a = p + inwards, b = p - inwards;
      const cv::Rect all(0, 0, small.cols, small.rows);
      if (!a.inside(all) || !b.inside(all)) continue;
      within += small.at<uchar>(a);
      outside += small.at<uchar>(b);
      ink += small.at<uchar>(a) < threshold ? 1 : 0;
      ++count;
    }
    if (count < 50 || within - outside < kContrast * count || ink > kMostInk * count) return false;
  }
  return true;
}

// What lies around the page is no even grey: between a twentieth and 19 twentieths of it lie 6 grey levels.
bool HasUnevenBackground(const cv::Mat& brightness, const Quadrilateral& page) {
  cv::Mat within = cv::Mat::zeros(brightness.size(), CV_8U);
  Outline corners;
  for (const cv::Point2d& p : page) corners.emplace_back(cv::Point(p));
  cv::fillConvexPoly(within, corners, cv::Scalar(255));
  const int margin = std::max(3, static_cast<int>(0.01 * std::hypot(within.cols, within.rows)));
  cv::dilate(within, within, cv::Mat::ones(2 * margin + 1, 2 * margin + 1, CV_8U));
  std::vector<uchar> around;
  for (int y = 0; y < brightness.rows; ++y) {
    for (int x = 0; x < brightness.cols; ++x) {
      if (within.at<uchar>(y, x) == 0) around.push_back(brightness.at<uchar>(y, x));
    }
  }
  if (around.size() < 400) return false;
  std::sort(around.begin(), around.end());
  constexpr int kUneven = 6;
  return around[around.size() * 19 / 20] - around[around.size() / 20] >= kUneven;
}

// Width by height of the rectangle that is seen as this quadrilateral. Where two opposite sides are nearly parallel,
// the corners do not tell the focal length: it is taken as usual (30 mm on 35 mm film); else it is kept between 22 and
// 90 mm.
double AspectRatio(const Quadrilateral& page, const cv::Size& picture) {
  const auto ray = [&](int i) {
    return cv::Vec3d(page[i].x - (picture.width - 1) / 2.0, page[i].y - (picture.height - 1) / 2.0, 1);
  };
  const cv::Vec3d m1 = ray(0), m2 = ray(1), m4 = ray(2), m3 = ray(3);  // as in the paper: m3 is the lower left one
  const double k2 = m1.cross(m4).dot(m3) / m2.cross(m4).dot(m3);
  const double k3 = m1.cross(m4).dot(m2) / m3.cross(m4).dot(m2);
  const cv::Vec3d n2 = k2 * m2 - m1, n3 = k3 * m3 - m1;
  const double diagonal = std::hypot(picture.width, picture.height);
  constexpr double kShortest = 0.5, kUsual = 0.7, kLongest = 2.1;  // of the diagonal
  double focal = kUsual * diagonal;
  // How much nearer to each other the far ends of two opposite sides are: what is less drowns in the corners' errors.
  constexpr double kVanishing = 0.15;
  const auto vanishing = [&](const cv::Vec3d& n) { return std::abs(n[2]) * diagonal / std::hypot(n[0], n[1]); };
  const double across = -(n2[0] * n3[0] + n2[1] * n3[1]), depth = n2[2] * n3[2];
  if (std::min(vanishing(n2), vanishing(n3)) > kVanishing && across / depth > 0) {
    focal = std::clamp(std::sqrt(across / depth), kShortest * diagonal, kLongest * diagonal);
  }
  const auto length = [&](const cv::Vec3d& n) { return std::hypot(n[0] / focal, n[1] / focal, n[2]); };
  return length(n2) / length(n3);
}

Page PageOf(const Quadrilateral& corners, const cv::Size& picture) {
  const auto side = [&](int i) { return cv::norm(corners[(i + 1) % 4] - corners[i]); };
  const double ratio = AspectRatio(corners, picture);
  // As fine as the photo is where it is nearest.
  double height = std::max({side(1), side(3), side(0) / ratio, side(2) / ratio});
  height = std::min(height, std::sqrt(static_cast<double>(kMaxSheetPixels) / ratio));
  const double width = ratio * height;
  constexpr double kEdge = 0.007;  // of the page: its own edge is no line of the drawing
  const auto low = static_cast<float>(-kEdge);
  const auto high = static_cast<float>(1 + kEdge);
  std::array<cv::Point2f, 4> from, to;
  const std::array<cv::Point2f, 4> unit = {{{low, low}, {high, low}, {high, high}, {low, high}}};
  for (int i = 0; i < 4; ++i) {
    from[i] = corners[i];
    to[i] = {static_cast<float>(unit[i].x * width), static_cast<float>(unit[i].y * height)};
  }
  return {cv::Matx33d(cv::getPerspectiveTransform(from.data(), to.data())),
          {static_cast<int>(width), static_cast<int>(height)}};
}

}  // namespace

std::optional<Page> FindPage(const cv::Mat& brightness) {
  const cv::Mat small = ShrunkTo(brightness, kSearchDiagonal);
  double threshold = 0;
  const Outline outline = BrightestArea(small, threshold);
  constexpr double kLeastShare = 0.15;
  if (outline.empty() || cv::contourArea(outline) < kLeastShare * static_cast<double>(small.total()))
    return std::nullopt;
  if (!LiesWithin(outline, small.size())) return std::nullopt;
  const std::optional<Outline> corners = FourCornersOf(outline);
  if (!corners) return std::nullopt;
  std::optional<Quadrilateral> page = FitQuadrilateral(outline, *corners);
  if (!page || !StandsOut(small, *page, threshold)) return std::nullopt;
  const double scale = static_cast<double>(brightness.cols) / small.cols;
  for (cv::Point2d& p : *page) p = scale * (p + cv::Point2d(0.5, 0.5)) - cv::Point2d(0.5, 0.5);
  if (!HasUnevenBackground(brightness, *page)) return std::nullopt;
  return PageOf(*page, brightness.size());
}

Sheet Rectify(const Sheet& photo, const Page& page) {
  Sheet sheet;
  cv::warpPerspective(photo.brightness, sheet.brightness, page.H_page_photo, page.size, cv::INTER_LINEAR,
                      cv::BORDER_REPLICATE);
  if (!photo.colour.empty()) {
    cv::warpPerspective(photo.colour, sheet.colour, page.H_page_photo, page.size, cv::INTER_LINEAR,
                        cv::BORDER_REPLICATE);
  }
  return sheet;
}

}  // namespace enfilade::perception
