// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/door_candidate.h"

#include <algorithm>
#include <cmath>

namespace enfilade::rooms {
namespace {

Eigen::Vector2d CentreOf(const GroundMap& ground, std::size_t cell) {
  const auto width = static_cast<std::size_t>(ground.width);
  return {static_cast<double>(cell % width), static_cast<double>(cell / width)};
}

bool IsSolid(const GroundMap& ground, const Eigen::Vector2d& p) {
  return !ground.IsOpen(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
}

// The obstacle nearest to `from` within `reach` cells of `around` that `accept` allows.
template <typename Accept>
std::optional<Eigen::Vector2d> NearestWall(const GroundMap& ground, const Eigen::Vector2d& from,
                                           const Eigen::Vector2d& around, double reach, Accept&& accept) {
  std::optional<Eigen::Vector2d> nearest;
  double least = 1e18;
  const int radius = static_cast<int>(reach);
  const int column = static_cast<int>(std::lround(around.x()));
  const int row = static_cast<int>(std::lround(around.y()));
  for (int y = row - radius; y <= row + radius; ++y) {
    for (int x = column - radius; x <= column + radius; ++x) {
      if (!ground.contains(x, y) || ground.IsOpen(x, y)) continue;
      const Eigen::Vector2d p(x, y);
      const double squared = (p - from).squaredNorm();
      if (squared >= least || !accept(p)) continue;
      least = squared;
      nearest = p;
    }
  }
  return nearest;
}

Ground GroundAt(const GroundMap& ground, const Eigen::Vector2d& p) {
  return ground.at(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
}

// One side of a wall, from the line that is followed to open ground.
struct WallSide {
  int steps = -1;     // to open ground; -1: none within the limit
  bool seen = false;  // a wall was seen before it
};

WallSide LookAside(const GroundMap& ground, const Eigen::Vector2d& from, const Eigen::Vector2d& direction, int limit) {
  WallSide side;
  for (int step = 1; step <= limit; ++step) {
    const Ground kind = GroundAt(ground, from + step * direction);
    if (kind >= Ground::kOpen) {
      side.steps = step;
      return side;
    }
    side.seen = side.seen || kind == Ground::kWall;
  }
  return side;
}

// Follows the wall along one line from the jamb outwards.
JambEvidence FollowLine(const GroundMap& ground, const Eigen::Vector2d& start, const Eigen::Vector2d& outward) {
  constexpr double kLongest = 2.0;    // m
  constexpr double kMissing = 0.2;    // m
  constexpr double kThickest = 0.55;  // m
  const Eigen::Vector2d aside(-outward.y(), outward.x());
  const double cell = ground.resolution;
  const int limit = static_cast<int>(kThickest / cell);
  JambEvidence jamb;
  int missing = 0;
  int slender = 0;
  int facing = 0;
  double thickness = 0.0;
  for (int step = 1; step <= static_cast<int>(kLongest / cell); ++step) {
    const Eigen::Vector2d p = start + step * outward;
    if (!IsSolid(ground, p)) {
      if (++missing * cell > kMissing) break;
      continue;
    }
    missing = 0;
    const bool seen = GroundAt(ground, p) == Ground::kWall;
    const WallSide left = LookAside(ground, p, aside, limit);
    const WallSide right = LookAside(ground, p, -aside, limit);
    const bool wall_seen = seen || left.seen || right.seen;
    if (left.steps > 0 && right.steps > 0 && left.steps + right.steps - 1 <= limit && wall_seen) {
      ++slender;
      thickness += (left.steps + right.steps - 1) * cell;
    } else if ((left.steps > 0 && right.steps < 0 && (seen || left.seen)) ||
               (right.steps > 0 && left.steps < 0 && (seen || right.seen))) {
      ++facing;
    } else {
      break;
    }
  }
  jamb.slender = slender * cell;
  jamb.facing = facing * cell;
  jamb.thickness = slender > 0 ? thickness / slender : 0.0;
  return jamb;
}

// How far a wall runs from the jamb in `direction`, just outside of the line's end.
double FollowAcross(const GroundMap& ground, const Eigen::Vector2d& jamb, const Eigen::Vector2d& outward,
                    const Eigen::Vector2d& direction) {
  constexpr double kLongest = 1.0;  // m
  constexpr double kMissing = 0.15;
  const int steps = static_cast<int>(kLongest / ground.resolution);
  const int aside = std::max(2, static_cast<int>(0.15 / ground.resolution));
  int missing = 0;
  int last = 0;
  for (int step = 1; step <= steps; ++step) {
    bool solid = false;
    for (int k = -aside; k <= aside && !solid; ++k) {
      solid = GroundAt(ground, jamb + step * direction + k * outward) == Ground::kWall;
    }
    missing = solid ? 0 : missing + 1;
    if (missing * ground.resolution > kMissing) break;
    if (solid) last = step;
  }
  return last * ground.resolution;
}

JambEvidence JambAt(const GroundMap& ground, const Eigen::Vector2d& jamb, const Eigen::Vector2d& outward) {
  const Eigen::Vector2d aside(-outward.y(), outward.x());
  JambEvidence best;
  const int reach = std::max(1, static_cast<int>(0.2 / ground.resolution));
  for (int degrees = -15; degrees <= 15; degrees += 5) {
    const double c = std::cos(degrees * M_PI / 180.0);
    const double s = std::sin(degrees * M_PI / 180.0);
    const Eigen::Vector2d direction = c * outward + s * aside;
    for (int k = -reach; k <= reach; ++k) {
      const JambEvidence found = FollowLine(ground, jamb + k * aside, direction);
      if (found.slender + 0.5 * found.facing > best.slender + 0.5 * best.facing) best = found;
    }
  }
  best.across_before = FollowAcross(ground, jamb, outward, aside);
  best.across_behind = FollowAcross(ground, jamb, outward, -aside);
  return best;
}

// How much farther the open ground reaches than the line, beside it at `at`.
double WidthBeyond(const GroundMap& ground, const Eigen::Vector2d& at, const Eigen::Vector2d& along, double half) {
  constexpr double kMost = 1.0;  // m beyond each jamb
  const double most = half + kMost / ground.resolution;
  double width = 0.0;
  for (const double sign : {-1.0, 1.0}) {
    double reached = 0.0;
    while (reached < most && !IsSolid(ground, at + sign * (reached + 1.0) * along)) reached += 1.0;
    width += reached;
  }
  return (width - 2.0 * half) * ground.resolution;
}

}  // namespace

std::optional<DoorCandidate> CandidateAt(const GroundMap& ground, const DistanceField& field, std::size_t place,
                                         double max_length) {
  if (field.nearest[place] == DistanceField::kNone) return std::nullopt;
  const Eigen::Vector2d middle = CentreOf(ground, place);
  DoorCandidate candidate;
  candidate.a = CentreOf(ground, field.nearest[place]);
  const Eigen::Vector2d to_a = candidate.a - middle;
  const auto opposite = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d to_p = p - middle;
    return to_p.dot(to_a) < -0.5 * to_p.norm() * to_a.norm();
  };
  const auto b = NearestWall(ground, middle, middle, 1.8 * to_a.norm() + 4.0, opposite);
  if (!b) return std::nullopt;
  candidate.b = *b;
  // The shortest line near it.
  const double reach = 0.4 / ground.resolution;
  for (int round = 0; round < 4; ++round) {
    const Eigen::Vector2d before_a = candidate.a;
    const Eigen::Vector2d before_b = candidate.b;
    const Eigen::Vector2d along = (candidate.b - candidate.a).normalized();
    const auto beyond_a = [&](const Eigen::Vector2d& p) { return (p - middle).dot(along) < 0.0; };
    const auto beyond_b = [&](const Eigen::Vector2d& p) { return (p - middle).dot(along) > 0.0; };
    if (const auto a = NearestWall(ground, candidate.b, candidate.a, reach, beyond_a)) candidate.a = *a;
    if (const auto other = NearestWall(ground, candidate.a, candidate.b, reach, beyond_b)) candidate.b = *other;
    if (candidate.a == before_a && candidate.b == before_b) break;
  }
  if (candidate.length() > max_length) return std::nullopt;
  return candidate;
}

DoorEvidence GatherEvidence(const GroundMap& ground, const DoorCandidate& candidate) {
  const Eigen::Vector2d along = (candidate.b - candidate.a).normalized();
  const Eigen::Vector2d aside(-along.y(), along.x());
  DoorEvidence evidence;
  evidence.width = (candidate.length() - 1.0) * ground.resolution;
  evidence.b = JambAt(ground, candidate.b, along);
  evidence.a = JambAt(ground, candidate.a, -along);
  std::swap(evidence.a.across_before, evidence.a.across_behind);
  const double half = candidate.length() / 2.0;
  const Eigen::Vector2d step = 0.5 / ground.resolution * aside;
  evidence.wider_before = WidthBeyond(ground, candidate.middle() + step, along, half);
  evidence.wider_behind = WidthBeyond(ground, candidate.middle() - step, along, half);
  return evidence;
}

double OpennessOf(const DoorEvidence& evidence) {
  const auto strength = [](const JambEvidence& jamb) {
    return std::min(1.0, (jamb.slender + 0.5 * jamb.facing) / 0.6);
  };
  const auto corner = [](const JambEvidence& jamb) {
    return std::min(1.0, std::max(jamb.across_before, jamb.across_behind) / 0.5);
  };
  const double a = strength(evidence.a);
  const double b = strength(evidence.b);
  const double jambs = std::max({a * b, a * 0.8 * corner(evidence.b), b * 0.8 * corner(evidence.a)});
  return 2.0 - 5.0 * jambs + std::max(0.0, evidence.width - 1.2);
}

}  // namespace enfilade::rooms
