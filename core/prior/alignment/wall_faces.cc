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

struct Foot {
  double fraction;
  Eigen::Vector2d point;
};

Foot FootOn(const WallFace& face, const Eigen::Vector2d& point) {
  const Eigen::Vector2d way = face.to - face.from;
  const double squared = way.squaredNorm();
  const double fraction = squared > 0 ? std::clamp((point - face.from).dot(way) / squared, 0.0, 1.0) : 0.0;
  return {fraction, face.from + fraction * way};
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
  for (const WallFace& face : faces_) {
    min_ = min_.cwiseMin(face.from).cwiseMin(face.to);
    max = max.cwiseMax(face.from).cwiseMax(face.to);
  }
  min_.array() -= reach;
  max.array() += reach;
  columns_ = std::min(kMostBuckets, BucketOf((max.x() - min_.x()) / bucket_) + 1);
  rows_ = std::min(kMostBuckets, BucketOf((max.y() - min_.y()) / bucket_) + 1);

  // Twice: first the sizes of the buckets, then what is in them.
  const auto for_each_bucket = [&](const auto& act) {
    const double farthest = reach + bucket_ * M_SQRT1_2;
    for (int i = 0; i < static_cast<int>(faces_.size()); ++i) {
      const WallFace& face = faces_[i];
      const Eigen::Vector2d low = ((face.from.cwiseMin(face.to) - min_).array() - reach) / bucket_;
      const Eigen::Vector2d high = ((face.from.cwiseMax(face.to) - min_).array() + reach) / bucket_;
      const int right = std::min(columns_ - 1, BucketOf(high.x()));
      const int top = std::min(rows_ - 1, BucketOf(high.y()));
      for (int row = std::max(0, BucketOf(low.y())); row <= top; ++row) {
        for (int column = std::max(0, BucketOf(low.x())); column <= right; ++column) {
          const Eigen::Vector2d centre = min_ + bucket_ * Eigen::Vector2d(column + 0.5, row + 0.5);
          if ((FootOn(face, centre).point - centre).norm() <= farthest) act(row * columns_ + column, i);
        }
      }
    }
  };
  first_.assign(static_cast<size_t>(columns_) * rows_ + 1, 0);
  for_each_bucket([&](int bucket, int) { ++first_[bucket + 1]; });
  for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  members_.resize(first_.back());
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for_each_bucket([&](int bucket, int face) { members_[next[bucket]++] = face; });
}

std::optional<NearestFace> FaceIndex::Nearest(const Eigen::Vector2d& point, const Eigen::Vector2d& along,
                                              double max_angle, const Eigen::Vector2d& open) const {
  if (faces_.empty()) return std::nullopt;
  const Eigen::Vector2d offset = (point - min_) / bucket_;
  if (!(offset.x() >= 0 && offset.y() >= 0 && offset.x() < columns_ && offset.y() < rows_)) return std::nullopt;
  const int bucket = static_cast<int>(offset.y()) * columns_ + static_cast<int>(offset.x());
  const bool directed = along.squaredNorm() > 0;
  const double least_cosine = std::cos(max_angle);
  std::optional<NearestFace> nearest;
  double best = reach_;
  for (int i = first_[bucket]; i < first_[bucket + 1]; ++i) {
    const WallFace& face = faces_[members_[i]];
    if (face.outward.dot(open) < 0) continue;
    const Foot foot = FootOn(face, point);
    const double distance = (foot.point - point).norm();
    if (distance >= best) continue;
    const Eigen::Vector2d direction = (face.to - face.from).normalized();
    if (directed && std::abs(direction.dot(along)) < least_cosine) continue;
    best = distance;
    nearest = {
        .face = members_[i], .fraction = foot.fraction, .point = foot.point, .distance = distance, .along = direction};
  }
  return nearest;
}

}  // namespace enfilade::prior
