// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/passage_silence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/rooms/door_odds.h"
#include "core/rooms/path_narrows.h"

namespace enfilade::rooms {
namespace {

// How often robots went across each line.
std::vector<int> CountCrossings(const grid::GridGeometry& geometry, std::span<const Eigen::Vector2d> trajectory,
                                const std::vector<DoorLine>& lines) {
  std::vector<int> crossings(lines.size(), 0);
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    if (!((trajectory[i] - trajectory[i - 1]).norm() <= kLongestStep)) continue;
    const DoorCandidate step{ToCells(geometry, trajectory[i - 1]), ToCells(geometry, trajectory[i])};
    for (std::size_t k = 0; k < lines.size(); ++k) crossings[k] += Crosses(step, lines[k].line) ? 1 : 0;
  }
  return crossings;
}

// How many passages were reported at each line, or at another one across the same doorway.
std::vector<int> CountReports(const grid::GridGeometry& geometry, std::span<const PassageHint> passages,
                              const std::vector<DoorLine>& lines) {
  constexpr double kDoorway = 1.0;  // m
  std::vector<int> reports(lines.size(), 0);
  for (const PassageHint& passage : passages) {
    const DoorCandidate reported{ToCells(geometry, passage.a), ToCells(geometry, passage.b)};
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const DoorCandidate& line = lines[k].line;
      const bool reports_it = LieTogether(line, reported, kDoorway / geometry.resolution) || GoesAlong(line, reported);
      reports[k] += reports_it ? 1 : 0;
    }
  }
  return reports;
}

// The share of passages through doors that are reported.
double DetectionRate(const std::vector<DoorLine>& lines, const std::vector<int>& crossings,
                     const std::vector<int>& reports, const DoorOdds& odds) {
  constexpr double kClear = -2.0;
  int passed = 0;
  int reported = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (crossings[k] == 0) continue;
    DoorEvidence walls = lines[k].evidence;
    walls.reports = 0;
    if (odds.OpennessOf(walls) > kClear) continue;
    passed += crossings[k];
    reported += std::min(crossings[k], reports[k]);
  }
  return (reported + 1.0) / (passed + 2.0);  // Laplace's rule of succession
}

}  // namespace

double WidestReported(std::span<const PassageHint> passages) {
  constexpr double kMargin = 0.2;
  double widest = 0.0;
  for (const PassageHint& passage : passages) widest = std::max(widest, (passage.b - passage.a).norm() + kMargin);
  return widest;
}

void WeighSilence(const grid::GridGeometry& geometry, const RoomEvidence& evidence, const DoorOdds& odds,
                  std::vector<DoorLine>& lines) {
  constexpr double kMost = 10.0;
  if (evidence.passages.empty()) return;
  const std::vector<int> crossings = CountCrossings(geometry, evidence.trajectory, lines);
  const std::vector<int> reports = CountReports(geometry, evidence.passages, lines);
  const double one_passage = -std::log(1.0 - DetectionRate(lines, crossings, reports, odds));
  const double widest = WidestReported(evidence.passages);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const int silent = crossings[k] - reports[k];
    if (silent <= 0 || lines[k].evidence.width > widest) continue;
    lines[k].evidence.silence = std::min(silent * one_passage, kMost);
    lines[k].openness = odds.OpennessOf(lines[k].evidence);
  }
}

}  // namespace enfilade::rooms
