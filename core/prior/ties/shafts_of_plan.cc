// SPDX-License-Identifier: Apache-2.0
#include "core/prior/ties/shafts_of_plan.h"

#include <algorithm>
#include <cstddef>

#include "core/prior/plan/room_names.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

double DistanceTo(const Vector2d& point, const Vector2d& from, const Vector2d& to) {
  const Vector2d way = to - from;
  const double share = std::clamp((point - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
  return (from + share * way - point).norm();
}

// -1: there is none.
int Nearest(const Vector2d& point, const std::vector<Vector2d>& corners) {
  int nearest = -1;
  for (int i = 0; i < static_cast<int>(corners.size()); ++i) {
    const auto distance = [&](int corner) { return (corners[static_cast<std::size_t>(corner)] - point).norm(); };
    if (nearest < 0 || distance(i) < distance(nearest)) nearest = i;
  }
  return nearest;
}

}  // namespace

std::vector<char> WithWallsOfShafts(const PlanGraph& plan, const PlanTransform& T_plan_sheet,
                                    std::vector<char> is_seen) {
  if (std::find(is_seen.begin(), is_seen.end(), 1) == is_seen.end()) return is_seen;
  const auto end = [&](int corner) { return T_plan_sheet(plan.corners[static_cast<std::size_t>(corner)].point); };
  for (const PlanShaft& shaft : plan.shafts) {
    if (shaft.name.empty()) continue;
    for (const Vector2d& corner_sheet : shaft.outline) {
      const Vector2d corner = T_plan_sheet(corner_sheet);
      const auto distance = [&](const PlanWall& wall) { return DistanceTo(corner, end(wall.from), end(wall.to)); };
      const auto nearest =
          std::min_element(plan.walls.begin(), plan.walls.end(),
                           [&](const PlanWall& a, const PlanWall& b) { return distance(a) < distance(b); });
      is_seen[static_cast<std::size_t>(nearest - plan.walls.begin())] = 1;
    }
  }
  return is_seen;
}

std::vector<graph::ShaftInPlan> NamedShafts(const PlanGraph& plan, const PlanTransform& T_plan_sheet,
                                            const PlanFrame& frame) {
  std::vector<graph::ShaftInPlan> shafts;
  if (frame.corners.empty()) return shafts;
  for (const PlanShaft& drawn : plan.shafts) {
    if (drawn.name.empty()) continue;
    graph::ShaftInPlan& shaft = shafts.emplace_back();
    shaft.name = drawn.name;
    shaft.is_lift = drawn.kind == ShaftKind::kLift;
    for (const Vector2d& corner : drawn.outline) shaft.outline.push_back(T_plan_sheet(corner));
    if (AreaOf(shaft.outline) < 0) std::reverse(shaft.outline.begin(), shaft.outline.end());
    for (const Vector2d& corner : shaft.outline) shaft.held_by.push_back(Nearest(corner, frame.corners));
  }
  return shafts;
}

}  // namespace enfilade::prior
