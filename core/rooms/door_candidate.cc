// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/door_candidate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/pose2.h"

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
  int steps = -1;  // to open ground; -1: none within the limit
  int walls = 0;   // of the steps before it, those on a wall
  // The wall ends in unknown ground. Otherwise, without open ground, another wall begins here and runs away.
  bool Fades(int limit) const { return steps < 0 && 2 * walls <= limit; }
};

WallSide LookAside(const GroundMap& ground, const Eigen::Vector2d& from, const Eigen::Vector2d& direction, int limit) {
  WallSide side;
  for (int step = 1; step <= limit; ++step) {
    const Ground kind = GroundAt(ground, from + step * direction);
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
    if (!IsSolid(ground, p)) {
      if (++missing * cell > kMissing) break;
      continue;
    }
    missing = 0;
    const bool seen = GroundAt(ground, p) == Ground::kWall;
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
    if (IsSolid(ground, p)) {
      const WallSide left = LookAside(ground, p, aside, limit);
      const WallSide right = LookAside(ground, p, -aside, limit);
      const bool thin = left.steps > 0 && right.steps > 0 && left.steps + right.steps <= limit;
      if (thin || GroundAt(ground, p) == Ground::kWall) missing = 0;
      // Half a wall if only one side of it was seen.
      const bool facing = GroundAt(ground, p) == Ground::kWall && (left.steps > 0 || right.steps > 0);
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
      solid = GroundAt(ground, jamb + step * direction + k * outward) == Ground::kWall;
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
      const int x = static_cast<int>(std::lround(at.x())) + dx;
      const int y = static_cast<int>(std::lround(at.y())) + dy;
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
      free = GroundAt(ground, line.a + at * along + k * aside) != Ground::kClutter;
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
  const int column = static_cast<int>(std::lround(line.middle().x()));
  const int row = static_cast<int>(std::lround(line.middle().y()));
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

// From where the wall ends to the next wall.
std::optional<DoorCandidate> ContinueWall(const GroundMap& ground, const JambEvidence& wall, double max_length) {
  // The line starts beside the jamb: the wall may begin a little farther out.
  constexpr double kMissing = 0.25;  // m
  double out = 0.0;
  while (!IsSolid(ground, wall.wall_from + out * wall.wall_direction)) {
    out += 1.0;
    if (out * ground.resolution > kMissing) return std::nullopt;
  }
  Eigen::Vector2d last_wall = wall.wall_from + out * wall.wall_direction;
  int open = 0;  // cells since the wall
  for (double at = 0.0; at < max_length; at += 1.0) {
    const Eigen::Vector2d p = wall.wall_from - at * wall.wall_direction;
    const bool solid = IsSolid(ground, p);
    const auto centre = [](const Eigen::Vector2d& q) { return Eigen::Vector2d(std::round(q.x()), std::round(q.y())); };
    if (solid && open >= 2) return DoorCandidate{centre(last_wall), centre(p), false};
    open = solid ? 0 : open + 1;
    if (solid) last_wall = p;
  }
  return std::nullopt;
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
  evidence.width = ClearStretch(ground, candidate) * ground.resolution;
  evidence.b = JambAt(ground, candidate.b, along);
  evidence.a = JambAt(ground, candidate.a, -along);
  std::swap(evidence.a.across_before, evidence.a.across_behind);
  const double half = candidate.length() / 2.0;
  const Eigen::Vector2d step = 0.5 / ground.resolution * aside;
  evidence.wider_before = WidthBeyond(ground, candidate.middle() + step, along, half);
  evidence.wider_behind = WidthBeyond(ground, candidate.middle() - step, along, half);
  evidence.aligned = AlignedShare(ground, candidate);
  return evidence;
}

std::vector<double> ValuesOf(const DoorEvidence& evidence) {
  std::vector<double> values{evidence.width, evidence.wider_before, evidence.wider_behind, evidence.aligned};
  for (const JambEvidence* jamb : {&evidence.a, &evidence.b}) {
    values.insert(values.end(), {jamb->slender, jamb->facing, jamb->thickness, jamb->across_before, jamb->across_behind,
                                 jamb->seen, jamb->extent, jamb->farther});
  }
  return values;
}

std::vector<DoorCandidate> ContinueWalls(const GroundMap& ground, const DoorCandidate& line,
                                         const DoorEvidence& evidence, double max_length) {
  constexpr double kLeastWall = 0.3;  // m
  std::vector<DoorCandidate> lines;
  const auto add = [&](const JambEvidence& wall) {
    if (wall.slender + 0.5 * wall.facing < kLeastWall) return;
    if (const auto found = ContinueWall(ground, wall, max_length)) lines.push_back(*found);
  };
  add(evidence.a);
  add(evidence.b);
  // A wall that runs across the line and ends at it: a wide door beside a narrow corridor.
  const Eigen::Vector2d along = (line.b - line.a).normalized();
  const Eigen::Vector2d aside(-along.y(), along.x());
  for (const bool at_a : {true, false}) {
    const JambEvidence& jamb = at_a ? evidence.a : evidence.b;
    const Eigen::Vector2d& end = at_a ? line.a : line.b;
    if (jamb.across_before >= kLeastWall && jamb.across_behind < kLeastWall) add(JambAt(ground, end, aside));
    if (jamb.across_behind >= kLeastWall && jamb.across_before < kLeastWall) add(JambAt(ground, end, -aside));
  }
  return lines;
}

double OpennessOf(const DoorEvidence& evidence) {
  const JambEvidence& a = evidence.a;
  const JambEvidence& b = evidence.b;
  const auto part = [](double value, double whole) { return std::clamp(value / whole, 0.0, 1.0); };
  const auto slenderness = [&](const JambEvidence& jamb) {
    return part(jamb.slender / std::max(0.1, jamb.thickness), 3.0);
  };
  // Walls that run past both jambs, instead of ending there, are a corridor's.
  const double passing =
      std::min(std::max(a.across_before, a.across_behind), std::max(b.across_before, b.across_behind));
  const double past = part(passing, 0.5);
  const double wider = part(std::min(evidence.wider_before, evidence.wider_behind), 0.6);
  const double odds_of_door =
      -4.12 + 0.13 * wider - 2.38 * past - 3.38 * past * (1.0 - wider) -
      1.92 * std::clamp(evidence.width - 1.0, 0.0, 3.0) + 2.81 * part(std::min(a.extent, b.extent), 4.0) +
      3.06 * std::max(slenderness(a), slenderness(b)) + 1.49 * part(a.farther + b.farther, 4.0) +
      2.10 * part(std::min(a.farther, b.farther), 1.0) + 0.50 * part(evidence.aligned - 0.4, 0.4);
  return -odds_of_door;
}

}  // namespace enfilade::rooms
