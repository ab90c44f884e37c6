// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/directions.h"

#include <array>
#include <cmath>

namespace enfilade::prior {

double AngleOfLine(const Eigen::Vector2d& direction) {
  const double angle = std::fmod(std::atan2(direction.y(), direction.x()) + 2 * M_PI, M_PI);
  return angle >= M_PI ? 0 : angle;
}

double TurnOfLine(double a, double b) { return std::remainder(b - a, M_PI); }

std::vector<double> DominantDirections(const std::vector<WeightedDirection>& lines) {
  constexpr int kBins = 720;
  std::array<double, kBins> histogram{};
  double total = 0;
  for (const WeightedDirection& line : lines) {
    histogram[static_cast<int>(AngleOfLine(line.direction) / M_PI * kBins) % kBins] += line.weight;
    total += line.weight;
  }
  constexpr int kReachBins = 8;
  constexpr int kMost = 4;
  std::vector<double> found;
  while (static_cast<int>(found.size()) < kMost) {
    int best = 0;
    double most = -1;
    for (int i = 0; i < kBins; ++i) {
      double sum = 0;
      for (int k = -2; k <= 2; ++k) sum += histogram[(i + k + kBins) % kBins];
      if (sum > most) most = sum, best = i;
    }
    const double peak = (best + 0.5) * M_PI / kBins;
    double weight = 0, turn = 0;
    for (const WeightedDirection& line : lines) {
      const double away = TurnOfLine(peak, AngleOfLine(line.direction));
      if (std::abs(away) > kDirectionReach) continue;
      weight += line.weight;
      turn += line.weight * away;
    }
    if (weight <= 0 || weight < 0.1 * total) break;
    found.push_back(std::fmod(peak + turn / weight + M_PI, M_PI));
    for (int k = -2 * kReachBins; k <= 2 * kReachBins; ++k) histogram[(best + k + kBins) % kBins] = 0;
  }
  return found;
}

std::vector<double> DominantDirections(const PlanGraph& plan) {
  std::vector<WeightedDirection> lines;
  for (const PlanWall& wall : plan.walls) {
    lines.push_back({plan.corners[wall.to].point - plan.corners[wall.from].point, LengthOf(plan, wall)});
  }
  return DominantDirections(lines);
}

}  // namespace enfilade::prior
