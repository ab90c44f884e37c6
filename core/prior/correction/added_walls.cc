// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/added_walls.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

#include "core/prior/alignment/fitted_line.h"
#include "core/prior/alignment/wall_faces.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

constexpr double kReach = 0.5;        // m: walls of the map so near to one of the plan are that one
constexpr double kTurn = 0.2;         // rad, between neighbours on one piece
constexpr double kGap = 0.35;         // m, between neighbours
constexpr double kOff = 0.12;         // m, from the line of a piece
constexpr double kThickest = 0.4;     // m, between the faces of one wall
constexpr double kLeastPiece = 0.8;   // m
constexpr double kLeastLength = 1.5;  // m, of an added wall
constexpr double kTouching = 0.7;     // m, from a wall's end to the wall that it ends at: its last reach is not seen

double DistanceToSegment(const Vector2d& point, const Vector2d& from, const Vector2d& to) {
  const double squared = std::max(1e-12, (to - from).squaredNorm());
  const double t = std::clamp((point - from).dot(to - from) / squared, 0.0, 1.0);
  return (point - from - t * (to - from)).norm();
}

class AddedWallFinder {
 public:
  AddedWallFinder(const CorrectedPlan& corrected, const MapEvidence& evidence) : corrected_(corrected) {
    const FaceIndex index(corrected.faces(), kReach);
    for (const WallPoint& wall : evidence.walls) {
      // At corners the map does not know a direction.
      const Vector2d along = wall.straightness < kStraight ? Vector2d(Vector2d::Zero()) : wall.along;
      if (index.Nearest(wall.point, along, kParallel)) continue;
      buckets_[BucketOf(wall.point)].push_back(static_cast<int>(points_.size()));
      points_.push_back(wall);
    }
    taken_.assign(points_.size(), 0);
  }

  std::vector<AddedWall> Run() {
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (taken_[i] != 0 || points_[i].straightness < kStraight) continue;
      const FittedLine piece = FitLine(Grow(i));
      if (piece.length() >= kLeastPiece) pieces_.push_back(piece);
    }
    // The longest first, so that the faces of a wall join it and not each other's pieces.
    std::stable_sort(pieces_.begin(), pieces_.end(),
                     [](const FittedLine& a, const FittedLine& b) { return a.length() > b.length(); });
    JoinFaces();
    DropWhatStandsFree();
    return std::move(walls_);
  }

 private:
  using Bucket = std::pair<std::int64_t, std::int64_t>;

  static Bucket BucketOf(const Vector2d& point) {
    return {static_cast<std::int64_t>(std::floor(point.x() / kGap)),
            static_cast<std::int64_t>(std::floor(point.y() / kGap))};
  }

  // From neighbour to neighbour, along the direction of the first.
  std::vector<Vector2d> Grow(std::size_t seed) {
    const Vector2d along = points_[seed].along;
    std::vector<Vector2d> grown;
    std::vector<std::size_t> reached = {seed};
    taken_[seed] = 1;
    while (!reached.empty()) {
      const Vector2d point = points_[reached.back()].point;
      reached.pop_back();
      grown.push_back(point);
      const Bucket bucket = BucketOf(point);
      for (int x = -1; x <= 1; ++x) {
        for (int y = -1; y <= 1; ++y) {
          const auto members = buckets_.find({bucket.first + x, bucket.second + y});
          if (members == buckets_.end()) continue;
          for (const int member : members->second) {
            const auto next = static_cast<std::size_t>(member);
            if (taken_[next] != 0 || !GoesOn(points_[next], point, points_[seed].point, along)) continue;
            taken_[next] = 1;
            reached.push_back(next);
          }
        }
      }
    }
    if (grown.size() < 2) grown.push_back(grown.front());
    return grown;
  }

  static bool GoesOn(const WallPoint& next, const Vector2d& point, const Vector2d& origin, const Vector2d& along) {
    if ((next.point - point).norm() > kGap) return false;
    if (next.straightness >= kStraight && std::abs(next.along.dot(along)) < std::cos(kTurn)) return false;
    const Vector2d way = next.point - origin;
    // A line may turn a little from the direction of its first point.
    return std::abs(along.x() * way.y() - along.y() * way.x()) <= kOff + 0.03 * way.norm();
  }

  void JoinFaces() {
    std::vector<char> joined(pieces_.size(), 0);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (joined[i] != 0) continue;
      const FittedLine& line = pieces_[i];
      double least = line.least, most = line.most;
      double lowest = 0, highest = 0;  // of the faces, across
      for (std::size_t j = i + 1; j < pieces_.size(); ++j) {
        const FittedLine& other = pieces_[j];
        if (joined[j] != 0 || std::abs(other.along.dot(line.along)) < std::cos(kTurn)) continue;
        const double offset = line.OffsetOf(other.middle);
        const double a = line.along.dot(other.from() - line.middle), b = line.along.dot(other.to() - line.middle);
        if (std::abs(offset) > kThickest || std::max(a, b) < least - kGap || std::min(a, b) > most + kGap) continue;
        joined[j] = 1;
        least = std::min({least, a, b});
        most = std::max({most, a, b});
        lowest = std::min(lowest, offset);
        highest = std::max(highest, offset);
      }
      if (most - least < kLeastLength) continue;
      const Vector2d normal(-line.along.y(), line.along.x());
      const Vector2d middle = line.middle + 0.5 * (lowest + highest) * normal;
      walls_.push_back({middle + least * line.along, middle + most * line.along});
    }
  }

  // Whether `end` of the wall lies at another wall, which it meets at an angle or goes on. What runs beside a wall is
  // furniture at it.
  static bool EndsAt(const AddedWall& wall, const Vector2d& end, const Vector2d& from, const Vector2d& to) {
    if (DistanceToSegment(end, from, to) > kTouching) return false;
    const Vector2d along = (wall.to - wall.from).normalized();
    const Vector2d other = (to - from).normalized();
    if (std::abs(along.dot(other)) < std::cos(kParallel)) return true;
    const Vector2d way = end - from;
    return std::abs(other.x() * way.y() - other.y() * way.x()) <= kThickest / 2;
  }

  bool EndsAtPlan(const AddedWall& wall, const Vector2d& end) const {
    return std::any_of(corrected_.faces().begin(), corrected_.faces().end(),
                       [&](const WallFace& face) { return EndsAt(wall, end, face.from, face.to); });
  }

  void DropWhatStandsFree() {
    std::vector<char> held(walls_.size(), 0);
    for (bool any = true; any;) {
      any = false;
      for (std::size_t i = 0; i < walls_.size(); ++i) {
        if (held[i] != 0) continue;
        for (const Vector2d& end : {walls_[i].from, walls_[i].to}) {
          bool is_held = EndsAtPlan(walls_[i], end);
          for (std::size_t j = 0; j < walls_.size() && !is_held; ++j) {
            is_held = held[j] != 0 && EndsAt(walls_[i], end, walls_[j].from, walls_[j].to);
          }
          if (!is_held) continue;
          held[i] = 1;
          any = true;
          break;
        }
      }
    }
    std::vector<AddedWall> kept;
    for (std::size_t i = 0; i < walls_.size(); ++i) {
      if (held[i] != 0) kept.push_back(walls_[i]);
    }
    std::stable_sort(kept.begin(), kept.end(), [](const AddedWall& a, const AddedWall& b) {
      return (a.to - a.from).norm() > (b.to - b.from).norm();
    });
    walls_ = std::move(kept);
  }

  const CorrectedPlan& corrected_;
  std::vector<WallPoint> points_;  // that no wall of the plan explains
  std::map<Bucket, std::vector<int>> buckets_;
  std::vector<char> taken_;
  std::vector<FittedLine> pieces_;
  std::vector<AddedWall> walls_;
};

}  // namespace

std::vector<AddedWall> FindAddedWalls(const CorrectedPlan& corrected, const MapEvidence& evidence) {
  return AddedWallFinder(corrected, evidence).Run();
}

}  // namespace enfilade::prior
