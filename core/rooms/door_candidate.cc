// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/door_candidate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/pose2.h"
#include "core/geometry/segments.h"
#include "core/rooms/door_evidence.h"

namespace enfilade::rooms {
namespace {

Eigen::Vector2d RoundedToCell(const Eigen::Vector2d& p) { return {std::round(p.x()), std::round(p.y())}; }

// The obstacle nearest to `from` within `reach` cells of `around` that `accept` allows.
template <typename Accept>
std::optional<Eigen::Vector2d> NearestWall(const GroundMap& ground, const Eigen::Vector2d& from,
                                           const Eigen::Vector2d& around, double reach, Accept&& accept) {
  std::optional<Eigen::Vector2d> nearest;
  double least = 1e18;
  const int radius = static_cast<int>(reach);
  const int column = Rounded(around.x());
  const int row = Rounded(around.y());
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

// From a wall at `from` across open ground to the next wall.
std::optional<DoorCandidate> CrossOpening(const GroundMap& ground, const Eigen::Vector2d& from,
                                          const Eigen::Vector2d& direction, double max_length) {
  Eigen::Vector2d last_wall = from;
  int open = 0;  // cells since the wall
  for (double at = 0.0; at < max_length; at += 1.0) {
    const Eigen::Vector2d p = from + at * direction;
    const bool solid = !ground.IsOpen(p);
    if (solid && open >= 2) return DoorCandidate{RoundedToCell(last_wall), RoundedToCell(p)};
    open = solid ? 0 : open + 1;
    if (solid) last_wall = p;
  }
  return std::nullopt;
}

std::optional<DoorCandidate> ContinueWall(const GroundMap& ground, const JambEvidence& wall, double max_length) {
  // The line starts beside the jamb: the wall may begin a little farther out.
  constexpr double kMissing = 0.25;  // m
  double out = 0.0;
  while (ground.IsOpen(wall.wall_from + out * wall.wall_direction)) {
    out += 1.0;
    if (out * ground.resolution > kMissing) return std::nullopt;
  }
  return CrossOpening(ground, wall.wall_from + out * wall.wall_direction, -wall.wall_direction, max_length + out);
}

}  // namespace

std::optional<double> WallDirectionNear(const GroundMap& ground, const Eigen::Vector2d& at) {
  constexpr double kReach = 1.5;  // m
  constexpr int kBin = 5;         // degrees
  std::array<int, 90 / kBin> count{};
  std::array<double, 90 / kBin> offset{};
  const int reach = static_cast<int>(kReach / ground.resolution);
  const int column = Rounded(at.x());
  const int row = Rounded(at.y());
  for (int y = std::max(0, row - reach); y <= std::min(ground.height - 1, row + reach); ++y) {
    for (int x = std::max(0, column - reach); x <= std::min(ground.width - 1, column + reach); ++x) {
      const int direction = ground.direction[ground.index(x, y)];
      if (direction == 0) continue;
      const int degrees = (direction - 1) % 90;
      ++count[static_cast<std::size_t>(degrees / kBin)];
      offset[static_cast<std::size_t>(degrees / kBin)] += degrees % kBin;
    }
  }
  const auto most = std::max_element(count.begin(), count.end());
  if (*most == 0) return std::nullopt;
  const auto bin = static_cast<std::size_t>(most - count.begin());
  return (static_cast<double>(bin) * kBin + offset[bin] / *most) * kDegree;
}

std::optional<DoorCandidate> CandidateAt(const GroundMap& ground, const DistanceField& field, std::size_t place,
                                         double max_length) {
  if (field.nearest[place] == DistanceField::kNone) return std::nullopt;
  const Eigen::Vector2d middle = ground.CentreOf(place);
  DoorCandidate candidate;
  candidate.a = ground.CentreOf(field.nearest[place]);
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

std::vector<DoorCandidate> AlignWithWalls(const GroundMap& ground, const DoorCandidate& line, double max_length) {
  constexpr double kMostTurn = M_PI / 3.0;
  std::vector<DoorCandidate> lines;
  const std::optional<double> direction = WallDirectionNear(ground, line.middle());
  if (!direction) return lines;
  const Eigen::Vector2d along = (line.b - line.a).normalized();
  for (int quarter = 0; quarter < 4; ++quarter) {
    const double angle = *direction + quarter * M_PI / 2.0;
    const Eigen::Vector2d way(std::cos(angle), std::sin(angle));
    const double forward = way.dot(along);
    if (std::abs(forward) < std::cos(kMostTurn)) continue;
    if (const auto found = CrossOpening(ground, forward > 0.0 ? line.a : line.b, way, max_length)) {
      lines.push_back(*found);
    }
  }
  return lines;
}

bool Crosses(const DoorCandidate& one, const DoorCandidate& other) {
  return SegmentsCross(one.a, one.b, other.a, other.b);
}

bool LieTogether(const DoorCandidate& one, const DoorCandidate& other, double apart) {
  constexpr double kMostTurn = M_PI / 3.0;
  const double turn = std::abs((one.b - one.a).normalized().dot((other.b - other.a).normalized()));
  return turn >= std::cos(kMostTurn) && (one.middle() - other.middle()).norm() < apart;
}

bool GoesAlong(const DoorCandidate& line, const DoorCandidate& passage) {
  constexpr double kMostTurn = M_PI / 6.0;
  constexpr double kAside = 0.25;  // of the passage's length
  const Eigen::Vector2d along = (line.b - line.a).normalized();
  if (std::abs(along.dot((passage.b - passage.a).normalized())) < std::cos(kMostTurn)) return false;
  const Eigen::Vector2d from_a = passage.middle() - line.a;
  const double at = from_a.dot(along);
  return at > 0.0 && at < line.length() && (from_a - at * along).norm() < kAside * passage.length();
}

}  // namespace enfilade::rooms
