// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/line_context.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "core/rooms/shared_walls.h"

namespace enfilade::rooms {
namespace {

double ChanceOfDoor(const DoorLine& line) { return 1.0 / (1.0 + std::exp(line.openness)); }

// Doors in the same straight wall, each by the chance that the first look gives it.
double DoorsInRow(const GroundMap& ground, const std::vector<DoorLine>& lines, std::size_t k) {
  constexpr double kNear = 1.0;   // m
  constexpr double kFar = 15.0;   // m
  constexpr double kAside = 0.3;  // m
  constexpr double kMostTurn = M_PI / 18.0;
  const DoorCandidate& line = lines[k].line;
  if (line.length() < 1.0) return 0.0;
  const Eigen::Vector2d along = (line.b - line.a).normalized();
  const Eigen::Vector2d aside(-along.y(), along.x());
  double doors = 0.0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i == k || lines[i].line.length() < 1.0) continue;
    const Eigen::Vector2d to = (lines[i].line.middle() - line.middle()) * ground.resolution;
    const double distance = std::abs(to.dot(along));
    if (distance < kNear || distance > kFar || std::abs(to.dot(aside)) > kAside) continue;
    if (std::abs((lines[i].line.b - lines[i].line.a).normalized().dot(along)) < std::cos(kMostTurn)) continue;
    doors += ChanceOfDoor(lines[i]);
  }
  return doors;
}

// The share of the doors that are as wide. Half a door more, so that a few do not decide.
double DoorsAlike(const GroundMap& ground, const std::vector<DoorLine>& lines, std::size_t k) {
  constexpr double kAlike = 0.1;  // m
  double alike = 0.0;
  double all = 0.5;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i == k) continue;
    const double odds = ChanceOfDoor(lines[i]);
    all += odds;
    const double longer = (lines[i].line.length() - lines[k].line.length()) * ground.resolution;
    if (std::abs(longer) < kAlike) alike += odds;
  }
  return alike / all;
}

// The regions that a line that is rather open parts from each region, and the region itself.
std::vector<std::set<std::int32_t>> OpenAround(const CutGround& cut, const std::vector<DoorLine>& lines) {
  std::vector<std::set<std::int32_t>> around(cut.map.sizes.size());
  for (std::size_t i = 0; i < around.size(); ++i) around[i].insert(static_cast<std::int32_t>(i));
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const Sides& sides = cut.sides[k];
    if (lines[k].openness <= 0.0 || sides.before < 0 || sides.behind < 0) continue;
    around[static_cast<std::size_t>(sides.before)].insert(sides.behind);
    around[static_cast<std::size_t>(sides.behind)].insert(sides.before);
  }
  return around;
}

// Those of `some` that are not among `others`, but for `own`.
std::vector<std::int32_t> Without(const std::set<std::int32_t>& some, const std::set<std::int32_t>& others,
                                  std::int32_t own, std::int32_t opposite) {
  std::vector<std::int32_t> left;
  for (const std::int32_t region : some) {
    if (region == own || (region != opposite && !others.contains(region))) left.push_back(region);
  }
  return left;
}

using RegionPair = std::pair<std::int32_t, std::int32_t>;  // the lower region first

RegionPair BesideLine(const CutGround& cut, std::size_t k) {
  return std::minmax(cut.sides[k].before, cut.sides[k].behind);
}

double VoteOf(const DoorLine& line) {
  constexpr double kMost = 3.0;
  return std::clamp(line.openness, -kMost, kMost);
}

// All lines between two regions.
struct LinesBetween {
  double length = 0.0;  // m
  double votes = 0.0;
};

std::map<RegionPair, LinesBetween> LinesBetweenRegions(const GroundMap& ground, const CutGround& cut,
                                                       const std::vector<DoorLine>& lines) {
  std::map<RegionPair, LinesBetween> between;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    LinesBetween& all = between[BesideLine(cut, k)];
    all.length += lines[k].line.length() * ground.resolution;
    all.votes += VoteOf(lines[k]);
  }
  return between;
}

// A share of lines, and of the others without one of them. One line more, whose chance is one half, counts.
struct Share {
  double sum = 0.5;
  double count = 1.0;

  void Add(double value, bool counts) {
    sum += counts ? value : 0.0;
    count += counts ? 1.0 : 0.0;
  }
  double Without(double value, bool counts) const { return counts ? (sum - value) / (count - 1.0) : sum / count; }
};

std::vector<FirstLooks> FirstLooksOf(const std::vector<DoorLine>& lines) {
  constexpr double kClearDoor = 0.9;
  constexpr double kDoubtful = 2.0;
  const auto is_reported = [](const DoorLine& line) { return line.evidence.reports > 0; };
  const auto is_silent = [](const DoorLine& line) { return line.evidence.silence > 0.0; };
  const auto is_clear = [&](const DoorLine& line) { return ChanceOfDoor(line) > kClearDoor; };
  const auto doubt = [&](const DoorLine& line) { return std::abs(line.openness) < kDoubtful ? 1.0 : 0.0; };
  double votes = 0.0;
  Share reported;
  Share silent;
  Share detected;
  Share doubtful;
  for (const DoorLine& line : lines) {
    votes += VoteOf(line);
    reported.Add(ChanceOfDoor(line), is_reported(line));
    silent.Add(ChanceOfDoor(line), is_silent(line));
    detected.Add(is_reported(line) ? 1.0 : 0.0, is_clear(line));
    doubtful.Add(doubt(line), true);
  }
  const double others = std::max(static_cast<double>(lines.size()) - 1.0, 1.0);
  std::vector<FirstLooks> looks;
  for (const DoorLine& line : lines) {
    looks.push_back({.own = line.openness,
                     .others = (votes - VoteOf(line)) / others,
                     .reported = reported.Without(ChanceOfDoor(line), is_reported(line)),
                     .silent = silent.Without(ChanceOfDoor(line), is_silent(line)),
                     .detected = detected.Without(is_reported(line) ? 1.0 : 0.0, is_clear(line)),
                     .doubtful = doubtful.Without(doubt(line), true)});
  }
  return looks;
}

}  // namespace

std::vector<LineContext> ContextsOf(const GroundMap& ground, const CutGround& cut, const std::vector<DoorLine>& lines) {
  constexpr double kMost = 10.0;  // m
  const SharedWalls walls(ground, cut.map);
  const std::vector<std::set<std::int32_t>> around = OpenAround(cut, lines);
  const std::map<RegionPair, LinesBetween> between = LinesBetweenRegions(ground, cut, lines);
  const std::vector<FirstLooks> looks = FirstLooksOf(lines);
  std::vector<LineContext> contexts(lines.size());
  for (std::size_t k = 0; k < lines.size(); ++k) {
    LineContext& context = contexts[k];
    context.row = DoorsInRow(ground, lines, k);
    context.alike = DoorsAlike(ground, lines, k);
    context.looks = looks[k];
    const auto [one, other] = BesideLine(cut, k);
    if (one < 0 || one == other) continue;
    const std::set<std::int32_t>& around_one = around[static_cast<std::size_t>(one)];
    const std::set<std::int32_t>& around_other = around[static_cast<std::size_t>(other)];
    context.parted = std::min(kMost, walls.Between(one, other));
    context.parted_wide = std::min(kMost, walls.Between(Without(around_one, around_other, one, other),
                                                        Without(around_other, around_one, other, one)));
    context.opened = between.at({one, other}).length;
    context.rivals = between.at({one, other}).votes - VoteOf(lines[k]);
  }
  return contexts;
}

ContextValues ValuesOf(const LineContext& context) {
  constexpr double kLeast = 0.05;  // m
  return {context.parted,
          context.parted_wide,
          context.parted / std::max(kLeast, context.parted + context.opened),
          context.parted / std::max(kLeast, context.outline),
          context.rivals,
          context.row,
          context.alike,
          context.looks.own,
          context.looks.others,
          context.looks.reported,
          context.looks.silent,
          context.looks.detected,
          context.looks.doubtful};
}

}  // namespace enfilade::rooms
