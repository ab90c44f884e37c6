// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/wall_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace enfilade::prior {
namespace {

constexpr double kLeastBucket = 1.0;    // m
constexpr double kBucketByReach = 0.4;  // a wall is listed in all buckets within reach: small ones take long to fill
constexpr int kMostBuckets = 4096;      // a side

// `bucket`: an offset, in buckets. The result is cut to what an index can have.
int BucketOf(double bucket) {
  if (!(bucket < kMostBuckets)) return kMostBuckets;  // not a number, too
  return static_cast<int>(std::max(bucket, -1.0));
}

// What a strip of the plane has in common with something, from left to right; empty: low > high.
struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void Add(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
};

// Of the places within `reach` of a face, those between two heights. They are bounded by arcs about both ends and by
// two lines beside the face.
Span SpanOf(const WallFace& face, double reach, double bottom, double top) {
  Span span;
  for (const Eigen::Vector2d& end : {face.from, face.to}) {
    const double away = std::max({bottom - end.y(), end.y() - top, 0.0});
    if (!(away <= reach)) continue;
    const double half = std::sqrt(reach * reach - away * away);
    span.Add(end.x() - half);
    span.Add(end.x() + half);
  }
  const Eigen::Vector2d way = face.to - face.from;
  const double length = std::hypot(way.x(), way.y());
  if (!(length > 0)) return span;
  const Eigen::Vector2d aside = reach / length * Eigen::Vector2d(-way.y(), way.x());
  for (const Eigen::Vector2d& from : {Eigen::Vector2d(face.from + aside), Eigen::Vector2d(face.from - aside)}) {
    const auto [low, high] = std::minmax({from.y(), from.y() + way.y()});
    if (high < bottom || low > top) continue;
    for (const double y : {from.y(), from.y() + way.y()}) {
      const double fraction =
          way.y() != 0 ? std::clamp((std::clamp(y, bottom, top) - from.y()) / way.y(), 0.0, 1.0) : 0;
      span.Add(from.x() + fraction * way.x());
    }
    if (way.y() == 0) span.Add(from.x() + way.x());
  }
  return span;
}

}  // namespace

std::vector<WallFace> FacesOf(const PlanGraph& plan) {
  std::vector<WallFace> faces;
  for (int i = 0; i < static_cast<int>(plan.walls.size()); ++i) {
    const PlanWall& wall = plan.walls[i];
    const Eigen::Vector2d from = plan.corners[wall.from].point;
    const Eigen::Vector2d to = plan.corners[wall.to].point;
    const Eigen::Vector2d along = (to - from).normalized();
    const Eigen::Vector2d aside = 0.5 * wall.thickness * Eigen::Vector2d(-along.y(), along.x());
    faces.push_back({from + aside, to + aside, i, aside});
    if (wall.thickness > 0) faces.push_back({from - aside, to - aside, i, -aside});
  }
  return faces;
}

std::vector<WallFace> Transformed(const std::vector<WallFace>& faces, const PlanTransform& T_map_sheet) {
  std::vector<WallFace> moved = faces;
  for (WallFace& face : moved) {
    face.from = T_map_sheet(face.from);
    face.to = T_map_sheet(face.to);
    face.outward = T_map_sheet.linear * face.outward;
  }
  return moved;
}

FaceIndex::FaceIndex(std::vector<WallFace> faces, double reach)
    : faces_(std::move(faces)), reach_(reach), bucket_(std::max(kLeastBucket, kBucketByReach * reach)) {
  if (faces_.empty()) return;
  Eigen::Vector2d max = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());
  min_ = -max;
  lines_.reserve(faces_.size());
  for (const WallFace& face : faces_) {
    min_ = min_.cwiseMin(face.from).cwiseMin(face.to);
    max = max.cwiseMax(face.from).cwiseMax(face.to);
    const Eigen::Vector2d way = face.to - face.from;
    lines_.push_back({face.from, way, way.squaredNorm(), way.normalized(), face.outward});
  }
  min_.array() -= reach;
  max.array() += reach;
  columns_ = std::min(kMostBuckets, BucketOf((max.x() - min_.x()) / bucket_) + 1);
  rows_ = std::min(kMostBuckets, BucketOf((max.y() - min_.y()) / bucket_) + 1);

  // The buckets of one row that a face is in. What is rounded must not lose it.
  struct Run {
    int face;
    int first;
    int count;
  };
  std::vector<Run> runs;
  const double margin = 1e-3 * bucket_;
  for (int i = 0; i < static_cast<int>(faces_.size()); ++i) {
    const WallFace& face = faces_[i];
    const auto [low, high] = std::minmax({face.from.y(), face.to.y()});
    const int top = std::min(rows_ - 1, BucketOf((high - min_.y() + reach + margin) / bucket_));
    for (int row = std::max(0, BucketOf((low - min_.y() - reach - margin) / bucket_)); row <= top; ++row) {
      const double bottom = min_.y() + row * bucket_;
      const Span span = SpanOf(face, reach + margin, bottom - margin, bottom + bucket_ + margin);
      const int left = std::max(0, BucketOf((span.low - min_.x()) / bucket_));
      const int right = std::min(columns_ - 1, BucketOf((span.high - min_.x()) / bucket_));
      if (left <= right) runs.push_back({i, row * columns_ + left, right - left + 1});
    }
  }
  first_.assign(static_cast<size_t>(columns_) * rows_ + 1, 0);
  for (const Run& run : runs) {
    for (int k = 0; k < run.count; ++k) ++first_[run.first + k + 1];
  }
  for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  members_.resize(first_.back());
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for (const Run& run : runs) {
    for (int k = 0; k < run.count; ++k) members_[next[run.first + k]++] = run.face;
  }
}

std::optional<NearestFace> FaceIndex::Nearest(const Eigen::Vector2d& point, const Eigen::Vector2d& along,
                                              double max_angle, const Eigen::Vector2d& open) const {
  if (faces_.empty()) return std::nullopt;
  const Eigen::Vector2d offset = (point - min_) / bucket_;
  if (!(offset.x() >= 0 && offset.y() >= 0 && offset.x() < columns_ && offset.y() < rows_)) return std::nullopt;
  const int bucket = static_cast<int>(offset.y()) * columns_ + static_cast<int>(offset.x());
  const bool directed = along.squaredNorm() > 0;
  const double least_cosine = std::cos(max_angle);
  constexpr double kRounding = 1 + 1e-12;  // of squares: which of two faces is nearer the distances themselves tell
  std::optional<NearestFace> nearest;
  double best = reach_;
  double best_squared = kRounding * best * best;
  for (int i = first_[bucket]; i < first_[bucket + 1]; ++i) {
    const Line& line = lines_[members_[i]];
    if (line.outward.dot(open) < 0) continue;
    const double fraction =
        line.squared_length > 0 ? std::clamp((point - line.from).dot(line.way) / line.squared_length, 0.0, 1.0) : 0.0;
    const Eigen::Vector2d foot = line.from + fraction * line.way;
    const double squared = (foot - point).squaredNorm();
    if (squared > best_squared) continue;
    const double distance = std::sqrt(squared);
    if (distance >= best) continue;
    if (directed && std::abs(line.along.dot(along)) < least_cosine) continue;
    best = distance;
    best_squared = kRounding * best * best;
    nearest = {.face = members_[i], .fraction = fraction, .point = foot, .distance = distance, .along = line.along};
  }
  return nearest;
}

}  // namespace enfilade::prior
