// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/shared_walls.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace enfilade::graph {
namespace {

constexpr double kStep = 0.5;         // m, between samples
constexpr double kCell = 1.0;         // m
constexpr double kMostSamples = 1e5;  // of one wall

using Cell = std::pair<std::int64_t, std::int64_t>;

Cell CellOf(const Eigen::Vector2d& point) {
  const auto index = [](double value) {
    return static_cast<std::int64_t>(std::clamp(std::floor(value / kCell), -1e15, 1e15));
  };
  return {index(point.x()), index(point.y())};
}

// Points along the walls of a plan.
std::vector<Eigen::Vector2d> SamplesOf(const PlanTies& plan) {
  std::vector<Eigen::Vector2d> samples;
  for (const PlanStrut& strut : plan.struts) {
    if (strut.wall < 0) continue;
    const Eigen::Vector2d& from = plan.corners[static_cast<std::size_t>(strut.from)];
    const Eigen::Vector2d along = plan.corners[static_cast<std::size_t>(strut.to)] - from;
    const int count = 1 + static_cast<int>(std::min(along.norm() / kStep, kMostSamples));
    for (int i = 0; i < count; ++i) samples.push_back(from + (i + 0.5) / count * along);
  }
  return samples;
}

}  // namespace

double ShareOfWalls(const PlanTies& a, const PlanTies& b) {
  std::vector<Eigen::Vector2d> shorter = SamplesOf(a), longer = SamplesOf(b);
  if (shorter.size() > longer.size()) std::swap(shorter, longer);
  if (shorter.empty()) return 0;
  std::set<Cell> cells;
  for (const Eigen::Vector2d& point : longer) {
    const auto [x, y] = CellOf(point);
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) cells.insert({x + dx, y + dy});
    }
  }
  const auto shared = std::count_if(shorter.begin(), shorter.end(),
                                    [&](const Eigen::Vector2d& point) { return cells.contains(CellOf(point)); });
  return static_cast<double>(shared) / static_cast<double>(shorter.size());
}

}  // namespace enfilade::graph
