// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/door_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/geometry/pose2.h"

namespace enfilade::rooms {
namespace {

// One side of a wall, from the line that is followed to open ground.
struct WallSide {
  int steps = -1;  // to open ground; -1: none within the limit
  int walls = 0;   // of the steps before it, those on a wall
  // The wall ends in unknown ground. Otherwise, without open ground, another wall begins here and runs away.
  bool Fades(int limit) const { return steps < 0 && 2 * walls <= limit; }
};

WallSide LookAside(const GroundMap& ground, const Eigen::Vector2d& from, const Eigen::Vector2d& direction, int limit) {
  WallSide side;
  for (int step = 1; step <= limit; ++step) {
    const Ground kind = ground.at(from + step * direction);
    if (kind >= Ground::kOpen) {
      side.steps = step;
      return side;
    }
    side.walls += kind == Ground::kWall ? 1 : 0;
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
    if (ground.IsOpen(p)) {
      if (++missing * cell > kMissing) break;
      continue;
    }
    missing = 0;
    const bool seen = ground.at(p) == Ground::kWall;
    const WallSide left = LookAside(ground, p, aside, limit);
    const WallSide right = LookAside(ground, p, -aside, limit);
    const bool wall_seen = seen || left.walls > 0 || right.walls > 0;
    if (left.steps > 0 && right.steps > 0 && left.steps + right.steps - 1 <= limit && wall_seen) {
      ++slender;
      thickness += (left.steps + right.steps - 1) * cell;
    } else if ((left.steps > 0 && right.Fades(limit) && (seen || left.walls > 0)) ||
               (right.steps > 0 && left.Fades(limit) && (seen || right.walls > 0))) {
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

// The length of walls on the same straight line behind interruptions of up to 2.5 m, within 5 m of the jamb.
double FollowFarther(const GroundMap& ground, const Eigen::Vector2d& start, const Eigen::Vector2d& outward) {
  constexpr double kLongest = 5.0;   // m
  constexpr double kMissing = 2.5;   // m
  constexpr double kThickest = 0.6;  // m
  const Eigen::Vector2d aside(-outward.y(), outward.x());
  const int limit = static_cast<int>(kThickest / ground.resolution);
  int missing = 0;
  double walls = 0.0;
  for (int step = 1; step * ground.resolution <= kLongest && missing * ground.resolution <= kMissing; ++step) {
    const Eigen::Vector2d p = start + step * outward;
    ++missing;
    if (!ground.IsOpen(p)) {
      const WallSide left = LookAside(ground, p, aside, limit);
      const WallSide right = LookAside(ground, p, -aside, limit);
      const bool thin = left.steps > 0 && right.steps > 0 && left.steps + right.steps <= limit;
      if (thin || ground.at(p) == Ground::kWall) missing = 0;
      // Half a wall if only one side of it was seen.
      const bool facing = ground.at(p) == Ground::kWall && (left.steps > 0 || right.steps > 0);
      walls += thin ? 1.0 : (facing ? 0.5 : 0.0);
    }
  }
  return walls * ground.resolution;
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
      solid = ground.at(jamb + step * direction + k * outward) == Ground::kWall;
    }
    missing = solid ? 0 : missing + 1;
    if (missing * ground.resolution > kMissing) break;
    if (solid) last = step;
  }
  return last * ground.resolution;
}

// What the obstacle at the jamb is.
void LookAtJamb(const GroundMap& ground, const Eigen::Vector2d& at, JambEvidence& jamb) {
  constexpr double kLongest = 4.0;  // m
  const int reach = std::max(1, static_cast<int>(0.15 / ground.resolution));
  int solid = 0;
  int walls = 0;
  int extent = 0;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const int x = Rounded(at.x()) + dx;
      const int y = Rounded(at.y()) + dy;
      if (!ground.contains(x, y) || ground.IsOpen(x, y)) continue;
      ++solid;
      if (ground.at(x, y) != Ground::kWall) continue;
      ++walls;
      extent = std::max(extent, int{ground.extent[ground.index(x, y)]});
    }
  }
  jamb.seen = solid > 0 ? std::min(1.0, 2.0 * walls / solid) : 0.0;
  jamb.extent = std::min(kLongest, extent * ground.resolution);
}

}  // namespace

JambEvidence JambAt(const GroundMap& ground, const Eigen::Vector2d& jamb, const Eigen::Vector2d& outward) {
  const Eigen::Vector2d aside(-outward.y(), outward.x());
  JambEvidence best;
  const int reach = std::max(1, static_cast<int>(0.1 / ground.resolution));
  for (int degrees = -10; degrees <= 10; degrees += 5) {
    const double c = std::cos(degrees * M_PI / 180.0);
    const double s = std::sin(degrees * M_PI / 180.0);
    const Eigen::Vector2d direction = c * outward + s * aside;
    for (int k = -reach; k <= reach; ++k) {
      const JambEvidence found = FollowLine(ground, jamb + k * aside, direction);
      if (found.slender + 0.5 * found.facing <= best.slender + 0.5 * best.facing) continue;
      best = found;
      best.wall_from = jamb + k * aside;
      best.wall_direction = direction;
    }
  }
  LookAtJamb(ground, jamb, best);
  for (int k = -reach; k <= reach; ++k) {
    best.farther = std::max(best.farther, FollowFarther(ground, jamb + k * aside, outward));
  }
  best.across_before = FollowAcross(ground, jamb, outward, aside);
  best.across_behind = FollowAcross(ground, jamb, outward, -aside);
  return best;
}

namespace {

// The longest stretch of the line that nothing stands on, in cells. A post between a door and a pane of glass is
// clutter: it stands free as far as the map shows.
double ClearStretch(const GroundMap& ground, const DoorCandidate& line) {
  constexpr int kReach = 2;  // cells beside the line
  const Eigen::Vector2d along = (line.b - line.a).normalized();
  const Eigen::Vector2d aside(-along.y(), along.x());
  double longest = 0.0;
  double clear = 0.0;
  for (double at = 1.0; at < line.length(); at += 1.0) {
    bool free = true;
    for (int k = -kReach; k <= kReach && free; ++k) {
      free = ground.at(line.a + at * along + k * aside) != Ground::kClutter;
    }
    clear = free ? clear + 1.0 : 0.0;
    longest = std::max(longest, clear);
  }
  return longest;
}

// The share of straight walls near the line that run along or across it.
double AlignedShare(const GroundMap& ground, const DoorCandidate& line) {
  constexpr double kReach = 2.5;  // m
  constexpr int kTolerance = 12;  // degrees
  const Eigen::Vector2d along = line.b - line.a;
  const int degrees = static_cast<int>(std::lround(std::atan2(along.y(), along.x()) / kDegree)) + 360;
  const int reach = static_cast<int>(kReach / ground.resolution);
  const int column = Rounded(line.middle().x());
  const int row = Rounded(line.middle().y());
  int straight = 0;
  int aligned = 0;
  for (int y = std::max(0, row - reach); y <= std::min(ground.height - 1, row + reach); ++y) {
    for (int x = std::max(0, column - reach); x <= std::min(ground.width - 1, column + reach); ++x) {
      const int direction = ground.direction[ground.index(x, y)];
      if (direction == 0) continue;
      ++straight;
      const int turn = (degrees - (direction - 1) + 360) % 90;
      aligned += std::min(turn, 90 - turn) <= kTolerance ? 1 : 0;
    }
  }
  return straight > 0 ? static_cast<double>(aligned) / straight : 0.0;
}

}  // namespace

DoorEvidence GatherEvidence(const GroundMap& ground, const DoorCandidate& candidate) {
  const Eigen::Vector2d along = (candidate.b - candidate.a).normalized();
  DoorEvidence evidence;
  evidence.width = ClearStretch(ground, candidate) * ground.resolution;
  evidence.length = candidate.length() * ground.resolution;
  evidence.b = JambAt(ground, candidate.b, along);
  evidence.a = JambAt(ground, candidate.a, -along);
  std::swap(evidence.a.across_before, evidence.a.across_behind);
  const auto is_open = [&](std::size_t cell) { return ground.IsOpen(cell); };
  evidence.wider_before = WidthBeyond(ground, candidate, 1.0, is_open);
  evidence.wider_behind = WidthBeyond(ground, candidate, -1.0, is_open);
  evidence.aligned = AlignedShare(ground, candidate);
  return evidence;
}

DoorValues ValuesOf(const DoorEvidence& evidence) {
  const JambEvidence& one = evidence.a;
  const JambEvidence& other = evidence.b;
  // The side where walls run farther from both jambs comes first.
  const auto order = [&](const double JambEvidence::*side) {
    return std::pair(std::min(one.*side, other.*side), std::max(one.*side, other.*side));
  };
  double JambEvidence::*walled = &JambEvidence::across_before;
  double JambEvidence::*bare = &JambEvidence::across_behind;
  if (order(walled) < order(bare)) std::swap(walled, bare);
  const auto values = [&](const JambEvidence& jamb) {
    return std::array<double, 8>{jamb.slender, jamb.facing, jamb.thickness, jamb.*walled,
                                 jamb.*bare,   jamb.seen,   jamb.extent,    jamb.farther};
  };
  const std::array<double, 8> a = values(evidence.a);
  const std::array<double, 8> b = values(evidence.b);
  DoorValues all{evidence.width, evidence.length, std::min(evidence.wider_before, evidence.wider_behind),
                 std::max(evidence.wider_before, evidence.wider_behind), evidence.aligned};
  for (std::size_t i = 0; i < a.size(); ++i) {
    all[5 + i] = std::min(a[i], b[i]);
    all[13 + i] = std::max(a[i], b[i]);
  }
  // Walls that run past both jambs, instead of ending there, are a corridor's.
  all[21] =
      std::min(std::max(one.across_before, one.across_behind), std::max(other.across_before, other.across_behind));
  all[22] = std::min({one.across_before, one.across_behind, other.across_before, other.across_behind});
  all[23] = std::min(one.*walled, other.*walled);
  all[24] = std::min(one.*bare, other.*bare);
  constexpr double kMostReports = 3.0;
  all[25] = std::min(static_cast<double>(evidence.reports), kMostReports);
  all[26] = evidence.silence;
  return all;
}

}  // namespace enfilade::rooms
