// SPDX-License-Identifier: Apache-2.0
#include "core/areas/simple_polygon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::areas {
namespace {

using Eigen::Vector2d;

struct Side {
  Vector2d from;
  Vector2d to;
};

double Turn(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double DistanceToSide(const Vector2d& point, const Side& side) {
  const Vector2d along = side.to - side.from;
  const Vector2d to_point = point - side.from;
  const double fraction = std::clamp(to_point.dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (to_point - fraction * along).norm();
}

bool BoxesTouch(const Side& a, const Side& b) {
  for (const int axis : {0, 1}) {
    const auto [a_low, a_high] = std::minmax({a.from[axis], a.to[axis]});
    const auto [b_low, b_high] = std::minmax({b.from[axis], b.to[axis]});
    if (a_low > b_high + kTouchDistance || b_low > a_high + kTouchDistance) return false;
  }
  return true;
}

// Each has its ends on both sides of the other.
bool Cross(const Side& a, const Side& b) {
  const Vector2d along_a = a.to - a.from;
  const Vector2d along_b = b.to - b.from;
  return Turn(along_a, b.from - a.from) * Turn(along_a, b.to - a.from) < 0.0 &&
         Turn(along_b, a.from - b.from) * Turn(along_b, a.to - b.from) < 0.0;
}

bool CrossOrTouch(const Side& a, const Side& b) {
  if (!BoxesTouch(a, b)) return false;
  if (Cross(a, b)) return true;
  return std::min({DistanceToSide(a.from, b), DistanceToSide(a.to, b), DistanceToSide(b.from, a),
                   DistanceToSide(b.to, a)}) <= kTouchDistance;
}

// Two sides with a corner between them: the later one may not go back along the earlier one.
bool FoldBack(const Side& earlier, const Side& later) {
  return DistanceToSide(earlier.from, later) <= kTouchDistance || DistanceToSide(later.to, earlier) <= kTouchDistance;
}

absl::Status ValidateCorners(const std::vector<Vector2d>& corners, double max_coordinate) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d& corner = corners[i];
    if (!corner.allFinite()) return InvalidArgument("corner {} is not finite", i);
    if (corner.cwiseAbs().maxCoeff() > max_coordinate) {
      return InvalidArgument("corner {} is at ({}, {}): coordinates are at most {} m", i, corner.x(), corner.y(),
                             max_coordinate);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValidateSimplePolygon(const std::vector<Vector2d>& corners, double max_coordinate) {
  const std::size_t count = corners.size();
  if (count < 3) return InvalidArgument("{} corners: at least 3 are needed", count);
  ENFILADE_RETURN_IF_ERROR(ValidateCorners(corners, max_coordinate));
  const auto side = [&](std::size_t i) { return Side{corners[i], corners[(i + 1) % count]}; };
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = (i + 1) % count;
    if ((corners[next] - corners[i]).norm() <= kTouchDistance) {
      return InvalidArgument("corners {} and {} are at one place, ({}, {}): leave one out", i, next, corners[i].x(),
                             corners[i].y());
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t next = (i + 1) % count;
    if (FoldBack(side(i), side(next))) {
      return InvalidArgument("side {} goes back along side {} at ({}, {}): leave that corner out", next, i,
                             corners[next].x(), corners[next].y());
    }
    for (std::size_t j = i + 2; j < count; ++j) {
      if (i == 0 && j + 1 == count) continue;
      if (CrossOrTouch(side(i), side(j))) {
        return InvalidArgument(
            "sides {} and {} cross or touch: a simple polygon is needed (sides count from 0; side 0 leads from the "
            "first corner to the second)",
            i, j);
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace enfilade::areas
