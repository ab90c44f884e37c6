// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/walls/wall_doors.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "perception/plan/walls/wall_openings.h"
#include "perception/plan/walls/weighted_median.h"

namespace enfilade::perception {
namespace {

// Each end is in one opening; those are chosen first of which `order` is least.
template <typename Order>
std::vector<Opening> OnePerEnd(const std::vector<Opening>& openings, const Order& order) {
  std::vector<std::pair<double, Opening>> sorted;
  for (const Opening& opening : openings) sorted.emplace_back(order(opening), opening);
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::unordered_set<int> used;
  std::vector<Opening> chosen;
  for (const auto& [value, opening] : sorted) {
    if (used.contains(opening.end) || (opening.other_end >= 0 && used.contains(opening.other_end))) continue;
    used.insert(opening.end);
    if (opening.other_end >= 0) used.insert(opening.other_end);
    chosen.push_back(opening);
  }
  return chosen;
}

// The width of a door in this plan: the median of what each end opens to first, by how likely these are doors.
double UsualWidth(const std::vector<Opening>& openings) {
  std::vector<std::pair<double, double>> widths;  // and their weights
  for (const Opening& opening : OnePerEnd(openings, [](const Opening& o) { return (1 + o.strangeness) * o.Width(); })) {
    widths.emplace_back(opening.Width(), std::exp(-opening.strangeness / 2));
  }
  return WeightedMedian(std::move(widths));
}

}  // namespace

std::vector<prior::PlanDoor> FindDoors(const prior::PlanGraph& plan, double diagonal) {
  constexpr double kReachShare = 0.08;  // of the diagonal
  constexpr double kWidth = 0.35;       // the standard deviation of the logarithm of doors' widths
  constexpr double kStrangest = 5;
  const double reach = plan.metres_per_unit ? 2.2 / *plan.metres_per_unit : kReachShare * diagonal;
  const double narrowest = plan.metres_per_unit ? 0.6 / *plan.metres_per_unit : 0;
  std::vector<Opening> openings = FindOpenings(plan, reach);
  std::erase_if(openings, [&](const Opening& opening) { return opening.Width() < narrowest; });
  const double usual = UsualWidth(openings);
  const auto strangeness = [&](const Opening& opening) {
    const double width = std::log(opening.Width() / usual) / kWidth;
    return width * width + opening.strangeness;
  };
  std::erase_if(openings, [&](const Opening& opening) { return !(strangeness(opening) <= kStrangest); });
  std::vector<prior::PlanDoor> doors;
  for (const Opening& opening : OnePerEnd(openings, strangeness)) {
    doors.push_back({opening.from, opening.to, opening.other_end >= 0 ? 0.7 : 0.5});
  }
  return doors;
}

}  // namespace enfilade::perception
