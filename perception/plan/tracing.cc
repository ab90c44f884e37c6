// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "core/geometry/segments.h"
#include "perception/plan/opencv_thinning.h"
#include "perception/plan/opencv_tracing.h"
#include "perception/plan/skeleton_chains.h"

namespace enfilade::perception {
namespace {

using Points = std::vector<Eigen::Vector2d>;
constexpr double kTolerance = 1.5;  // px

// The points where the line through all points bends: indices, the first and the last among them.
std::vector<int> BendsOf(const Points& points) {
  std::vector<int> bends{0, static_cast<int>(points.size()) - 1};
  std::vector<std::pair<int, int>> open{{bends[0], bends[1]}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    int farthest = -1;
    double most = kTolerance;
    for (int i = first + 1; i < last; ++i) {
      const double distance = DistanceToSegment(points[i], points[first], points[last]);
      if (distance > most) {
        most = distance;
        farthest = i;
      }
    }
    if (farthest < 0) continue;
    bends.push_back(farthest);
    open.emplace_back(first, farthest);
    open.emplace_back(farthest, last);
  }
  std::sort(bends.begin(), bends.end());
  return bends;
}

class Tracer {
 public:
  Tracer(const cv::Mat& half_width, const cv::Mat& mass, const ChainGraph& chains)
      : half_width_(half_width), mass_(mass), chains_(chains) {
    graph_.joints = chains.nodes;
  }

  StrokeGraph Trace() {
    for (const Chain& chain : chains_.chains) AddChain(chain);
    return std::move(graph_);
  }

 private:
  void AddChain(const Chain& chain) {
    Points points{chains_.nodes[chain.from]};
    widths_.assign(1, -1.0);
    for (const int i : chain.pixels) {
      points.emplace_back(i % half_width_.cols, i / half_width_.cols);
      widths_.push_back(WidthAt(i));
    }
    points.push_back(chains_.nodes[chain.to]);
    widths_.push_back(-1.0);
    std::vector<int> bends = BendsOf(points);
    DropShortPieces(points, bends);
    int from = chain.from;
    for (std::size_t k = 1; k < bends.size(); ++k) {
      const bool last = k + 1 == bends.size();
      const int to = last ? chain.to : static_cast<int>(graph_.joints.size());
      if (!last) graph_.joints.push_back(points[bends[k]]);
      AddPiece(points, bends[k - 1], bends[k], from, to);
      from = to;
    }
  }

  double WidthAt(int pixel) const {
    if (mass_.data[pixel] != 0) return 0;
    return std::max(1.0, 2.0 * reinterpret_cast<const float*>(half_width_.data)[pixel] - 1.0);
  }

  double MedianWidth(int first, int last) const {
    std::vector<double> widths;
    for (int i = first; i <= last; ++i) {
      if (widths_[i] >= 0) widths.push_back(widths_[i]);
    }
    if (widths.empty()) return 1;
    std::nth_element(widths.begin(), widths.begin() + static_cast<long>(widths.size() / 2), widths.end());
    return widths[widths.size() / 2];
  }

  // The skeleton of a wide stroke cuts corners: a piece shorter than the stroke is wide, between two longer ones.
  void DropShortPieces(const Points& points, std::vector<int>& bends) const {
    for (std::size_t k = 1; k + 2 < bends.size();) {
      const double length = (points[bends[k + 1]] - points[bends[k]]).norm();
      const double before = (points[bends[k]] - points[bends[k - 1]]).norm();
      const double after = (points[bends[k + 2]] - points[bends[k + 1]]).norm();
      const double width = MedianWidth(bends[k - 1], bends[k + 2]);
      if (length <= std::max(3.0, 0.8 * width) && before > length && after > length) {
        bends[k] = (bends[k] + bends[k + 1]) / 2;
        bends.erase(bends.begin() + static_cast<long>(k) + 1);
      } else {
        ++k;
      }
    }
  }

  void AddPiece(const Points& points, int first, int last, int from, int to) {
    Stroke stroke{.from = from, .to = to, .width = MedianWidth(first, last)};
    // Near the ends, the skeleton leaves the middle of a wide stroke.
    int trim = static_cast<int>(std::ceil(0.6 * stroke.width)) + 1;
    if (last - first < 2 * trim + 4) trim = std::max(0, (last - first - 4) / 2);
    for (int i = first + trim; i <= last - trim; ++i) stroke.moments.Add(points[i]);
    if (stroke.moments.count < 2) {
      stroke.moments.Add(points[first]);
      stroke.moments.Add(points[last]);
    }
    graph_.strokes.push_back(stroke);
  }

  const cv::Mat& half_width_;
  const cv::Mat& mass_;
  const ChainGraph& chains_;
  StrokeGraph graph_;
  std::vector<double> widths_;  // at the points of the current chain; -1: at a node
};

}  // namespace

StrokeGraph TraceStrokes(const Ink& ink) {
  cv::Mat inner;
  cv::erode(ink.mass, inner, cv::Mat::ones(3, 3, CV_8U));
  const cv::Mat drawn = ink.strokes | (ink.mass & ~inner);
  cv::Mat half_width;
  cv::copyMakeBorder(drawn, half_width, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::distanceTransform(half_width, half_width, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  half_width = half_width(cv::Rect(1, 1, drawn.cols, drawn.rows)).clone();
  const cv::Mat skeleton = Thin(drawn);
  const cv::Mat mass = ink.mass.isContinuous() ? ink.mass : ink.mass.clone();
  const ChainGraph chains =
      FollowSkeleton({skeleton.cols, skeleton.rows, skeleton.data, reinterpret_cast<const float*>(half_width.data)});
  return Tracer(half_width, mass, chains).Trace();
}

}  // namespace enfilade::perception
