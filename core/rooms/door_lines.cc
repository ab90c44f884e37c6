// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/door_lines.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <tuple>

#include "core/geometry/pose2.h"
#include "core/rooms/basins.h"
#include "core/rooms/door_odds.h"
#include "core/rooms/path_narrows.h"

namespace enfilade::rooms {
namespace {

// m, from wall to wall: a door may have panes of glass beside it.
double LongestLine(const RoomOptions& options) { return 1.4 * options.max_door; }

bool IsKnown(const DoorCandidate& line, double same, const std::vector<DoorLine>& lines) {
  return std::any_of(lines.begin(), lines.end(), [&](const DoorLine& known) {
    const bool forward = (known.line.a - line.a).norm() < same && (known.line.b - line.b).norm() < same;
    const bool reverse = (known.line.a - line.b).norm() < same && (known.line.b - line.a).norm() < same;
    return forward || reverse;
  });
}

// The line at a narrow place, and the walls' own lines across it where they look more like a door.
void AddDoorLine(const GroundMap& ground, const DoorCandidate& line, const RoomOptions& options, const DoorOdds& odds,
                 std::vector<DoorLine>& lines) {
  constexpr double kSame = 0.5;       // cells: holes in a wall may be neighbours, and each must be closed
  constexpr double kSmallHole = 0.5;  // m
  if (IsKnown(line, kSame, lines)) return;
  const DoorEvidence evidence = GatherEvidence(ground, line);
  DoorLine best{line, evidence, odds.OpennessOf(evidence)};
  const double one_door = 0.5 / ground.resolution;
  std::vector<DoorLine> others;
  const bool hole = line.length() * ground.resolution < kSmallHole;
  const double longest = LongestLine(options) / ground.resolution;
  std::vector<DoorCandidate> alternatives = ContinueWalls(ground, line, evidence, longest);
  const std::vector<DoorCandidate> aligned = AlignWithWalls(ground, line, longest);
  alternatives.insert(alternatives.end(), aligned.begin(), aligned.end());
  for (const DoorCandidate& other : alternatives) {
    if (hole || other.length() < 2.0 || IsKnown(other, kSame, lines)) continue;
    DoorLine found{other, GatherEvidence(ground, other), 0.0};
    found.openness = odds.OpennessOf(found.evidence);
    if (found.evidence.width > options.max_door || found.openness >= std::min(best.openness, 0.0)) continue;
    if (IsKnown(other, one_door, {best})) {
      best = found;
    } else {
      others.push_back(found);
    }
  }
  // Narrower than any door: a wall with a hole, or a slit between furniture. It is judged like a door.
  if (best.evidence.width <= options.max_door) lines.push_back(best);
  lines.insert(lines.end(), others.begin(), others.end());
}

// The line along a passage, from the wall at one end of it to that at the other, up to `farther` cells beyond its ends.
// An end without a wall there stays.
DoorCandidate AlongPassage(const GroundMap& ground, const DoorCandidate& passage, double farther) {
  // Robots measure a door's direction no better. Degrees.
  constexpr std::array<double, 7> kTurns{0.0, 5.0, -5.0, 10.0, -10.0, 15.0, -15.0};
  const Eigen::Vector2d middle = passage.middle();
  const auto extend = [&](const Eigen::Vector2d& end) -> Eigen::Vector2d {
    const double most = (end - middle).norm() + farther;
    for (const double turn : kTurns) {
      const Eigen::Vector2d way = Eigen::Rotation2Dd(turn * M_PI / 180.0) * (end - middle).normalized();
      for (double at = 1.0; at <= most; at += 1.0) {
        const Eigen::Vector2d p = middle + at * way;
        if (!ground.IsOpen(p)) return p;
      }
    }
    return end;
  };
  return {extend(passage.a), extend(passage.b)};
}

bool EndsOpen(const GroundMap& ground, const DoorLine& line) {
  return ground.IsOpen(line.line.a) || ground.IsOpen(line.line.b);
}

// The line of a passage where none is known: along it, or as the walls beside it go on, whatever looks more like a
// door. One jamb may be furniture, or a post with a pane of glass beside it. A line that ends on open ground parts
// nothing.
DoorLine LineAcross(const GroundMap& ground, const DoorCandidate& passage, const RoomOptions& options,
                    const DoorOdds& odds) {
  const auto judge = [&](const DoorCandidate& line) {
    DoorLine judged{line, GatherEvidence(ground, line), 0.0};
    judged.evidence.reports = 1;
    judged.openness = odds.OpennessOf(judged.evidence);
    return judged;
  };
  constexpr double kNear = 0.6;  // m
  DoorLine best = judge(AlongPassage(ground, passage, kNear / ground.resolution));
  const double longest = LongestLine(options) / ground.resolution;
  std::vector<DoorCandidate> others = ContinueWalls(ground, best.line, best.evidence, longest);
  others.push_back(AlongPassage(ground, passage, longest / 2.0));
  const std::vector<DoorCandidate> aligned = AlignWithWalls(ground, best.line, longest);
  others.insert(others.end(), aligned.begin(), aligned.end());
  for (const DoorCandidate& other : others) {
    if (!GoesAlong(other, passage)) continue;
    const DoorLine found = judge(other);
    if (found.evidence.width > options.max_door) continue;
    if (std::tuple(EndsOpen(ground, found), found.openness) < std::tuple(EndsOpen(ground, best), best.openness)) {
      best = found;
    }
  }
  best.evidence.reports = 0;
  return best;
}

// The line that a robot went through which reports a passage across `passage`: it may have gone through the door
// obliquely. Null: none.
DoorLine* LineOfPassage(const DoorCandidate& passage, double reach, std::vector<DoorLine>& lines) {
  DoorLine* nearest = nullptr;
  for (DoorLine& line : lines) {
    if (!LieTogether(line.line, passage, reach)) continue;
    reach = (line.line.middle() - passage.middle()).norm();
    nearest = &line;
  }
  if (nearest != nullptr) return nearest;
  const auto longer =
      std::find_if(lines.begin(), lines.end(), [&](const DoorLine& line) { return GoesAlong(line.line, passage); });
  return longer == lines.end() ? nullptr : &*longer;
}

// Of several lines across one opening the one that was reported stays: the others would vote on the same door again.
void DropRivals(const GroundMap& ground, double reach, std::vector<DoorLine>& lines) {
  std::vector<DoorLine> reported;
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(reported),
               [&](const DoorLine& line) { return line.evidence.reports > 0 && !EndsOpen(ground, line); });
  std::erase_if(lines, [&](const DoorLine& line) {
    return line.evidence.reports == 0 && std::any_of(reported.begin(), reported.end(), [&](const DoorLine& other) {
             return other.openness < line.openness && LieTogether(other.line, line.line, reach);
           });
  });
}

}  // namespace

std::vector<DoorLine> FindDoorLines(const GroundMap& ground, const DistanceField& field, const RoomOptions& options,
                                    const DoorOdds& odds) {
  const double cells = 1.0 / ground.resolution;  // per metre
  const double longest = LongestLine(options) * cells;
  const NarrowPlaces limits{std::max(1.0, options.narrowing * cells), longest / 2.0};
  std::vector<DoorLine> lines;
  for (const std::size_t place : FindNarrowPlaces(ground, field, limits)) {
    const auto line = CandidateAt(ground, field, place, longest);
    if (line) AddDoorLine(ground, *line, options, odds, lines);
  }
  return lines;
}

std::vector<DoorLine> JudgeNarrowsOnPath(const GroundMap& ground, const grid::GridGeometry& geometry,
                                         std::span<const Eigen::Vector2d> trajectory, const RoomOptions& options,
                                         const DoorOdds& odds, const std::vector<DoorLine>& known) {
  const double same = 0.2 / ground.resolution;
  std::vector<DoorLine> lines;
  for (const DoorCandidate& narrow : FindNarrowsOnPath(ground, geometry, trajectory, LongestLine(options))) {
    if (IsKnown(narrow, same, known)) continue;
    const DoorEvidence evidence = GatherEvidence(ground, narrow);
    lines.push_back({narrow, evidence, odds.OpennessOf(evidence)});
  }
  return lines;
}

void AddNarrowsOnPath(const GroundMap& ground, const grid::GridGeometry& geometry,
                      std::span<const Eigen::Vector2d> trajectory, const RoomOptions& options, const DoorOdds& odds,
                      std::vector<DoorLine>& lines) {
  std::vector<DoorLine> doors = JudgeNarrowsOnPath(ground, geometry, trajectory, options, odds, lines);
  std::erase_if(doors,
                [&](const DoorLine& door) { return door.openness >= 0.0 || door.evidence.width > options.max_door; });
  std::stable_sort(doors.begin(), doors.end(),
                   [](const DoorLine& a, const DoorLine& b) { return a.openness < b.openness; });
  const double apart = 1.0 / ground.resolution;
  for (const DoorLine& door : doors) {
    // Of two lines across one opening the clearer one stays.
    const auto rivals = [&](const DoorLine& line) {
      return Crosses(door.line, line.line) || LieTogether(door.line, line.line, apart);
    };
    const bool known = std::any_of(lines.begin(), lines.end(), [&](const DoorLine& line) {
      return line.openness <= door.openness && rivals(line);
    });
    if (known) continue;
    std::erase_if(lines, rivals);
    lines.push_back(door);
  }
}

void AddPassages(const GroundMap& ground, const grid::GridGeometry& geometry, std::span<const PassageHint> passages,
                 const RoomOptions& options, const DoorOdds& odds, std::vector<DoorLine>& lines) {
  const double reach = 0.6 / ground.resolution;
  for (const PassageHint& passage : passages) {
    const Eigen::Vector2d a = ToCells(geometry, passage.a);
    const Eigen::Vector2d b = ToCells(geometry, passage.b);
    if (!a.allFinite() || !b.allFinite() || (b - a).norm() < 1.0) continue;
    DoorLine* line = LineOfPassage({a, b}, reach, lines);
    if (line == nullptr) {
      DoorLine own = LineAcross(ground, {a, b}, options, odds);
      const bool crosses =
          std::any_of(lines.begin(), lines.end(), [&](const DoorLine& other) { return Crosses(own.line, other.line); });
      if (crosses) continue;  // it would cut the other line in two
      line = &lines.emplace_back(std::move(own));
    }
    ++line->evidence.reports;
    line->openness = odds.OpennessOf(line->evidence);
  }
  DropRivals(ground, reach, lines);
}

double JoinWeight(const DoorLine& line, double robot_radius) {
  constexpr double kMost = 3.0;
  constexpr double kLeast = 0.01;  // share
  if (line.openness <= 0.0) return line.openness;
  const double seen = std::min(line.evidence.a.seen, line.evidence.b.seen);
  const double sure = seen * std::min(line.evidence.width / (2.0 * robot_radius), 1.0);
  return std::min(line.openness, kMost) * std::max(sure * sure, kLeast);
}

}  // namespace enfilade::rooms
