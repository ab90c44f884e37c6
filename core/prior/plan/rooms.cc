// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/prior/plan/planar.h"
#include "core/prior/plan/room_names.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

// A wall seen from one of its sides. `twin` is the other side.
struct HalfWall {
  int from = 0;
  int to = 0;
  int next = -1;  // along the face on its left
  int twin = 0;
  bool visited = false;
};

// Walls and doors as one planar graph.
PlanGraph WithDoorsClosed(const PlanGraph& plan, double weld) {
  PlanGraph closed = plan;
  for (const PlanDoor& door : plan.doors) {
    if ((door.to - door.from).norm() <= weld) continue;
    const int from = static_cast<int>(closed.corners.size());
    closed.corners.push_back({door.from});
    closed.corners.push_back({door.to});
    closed.walls.push_back({.from = from, .to = from + 1});
  }
  return Planarise(closed, weld);
}

// Dead ends bound no face: walls are taken away from their ends on, until each end has another wall.
void DropDeadEnds(PlanGraph& plan) {
  std::vector<std::vector<int>> walls_of(plan.corners.size());
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    walls_of[plan.walls[i].from].push_back(static_cast<int>(i));
    walls_of[plan.walls[i].to].push_back(static_cast<int>(i));
  }
  std::vector<std::size_t> degree(plan.corners.size());
  std::vector<int> ends;
  for (std::size_t i = 0; i < plan.corners.size(); ++i) {
    degree[i] = walls_of[i].size();
    if (degree[i] == 1) ends.push_back(static_cast<int>(i));
  }
  std::vector<char> is_dropped(plan.walls.size(), 0);
  while (!ends.empty()) {
    const int end = ends.back();
    ends.pop_back();
    for (const int wall : walls_of[end]) {
      if (is_dropped[wall] != 0) continue;
      is_dropped[wall] = 1;
      for (const int corner : {plan.walls[wall].from, plan.walls[wall].to}) {
        if (--degree[corner] == 1) ends.push_back(corner);
      }
    }
  }
  std::vector<PlanWall> kept;
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    if (is_dropped[i] == 0) kept.push_back(plan.walls[i]);
  }
  plan.walls = std::move(kept);
}

std::vector<HalfWall> HalfWallsOf(const PlanGraph& plan) {
  std::vector<HalfWall> halves;
  std::vector<std::vector<int>> leaving(plan.corners.size());
  for (const PlanWall& wall : plan.walls) {
    const int first = static_cast<int>(halves.size());
    halves.push_back({.from = wall.from, .to = wall.to, .twin = first + 1});
    halves.push_back({.from = wall.to, .to = wall.from, .twin = first});
    leaving[wall.from].push_back(first);
    leaving[wall.to].push_back(first + 1);
  }
  const auto angle = [&](int half) {
    const Vector2d along = plan.corners[halves[half].to].point - plan.corners[halves[half].from].point;
    return std::atan2(along.y(), along.x());
  };
  for (std::vector<int>& around : leaving) {
    std::sort(around.begin(), around.end(), [&](int a, int b) { return angle(a) < angle(b); });
    for (std::size_t i = 0; i < around.size(); ++i) {
      // Arriving by the twin, the face continues with the neighbour before it.
      halves[halves[around[i]].twin].next = around[(i + around.size() - 1) % around.size()];
    }
  }
  return halves;
}

double CircumferenceOf(const std::vector<Vector2d>& outline) {
  double sum = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) sum += (outline[(i + 1) % outline.size()] - outline[i]).norm();
  return sum;
}

}  // namespace

std::vector<PlanRoom> FindRooms(const PlanGraph& plan, double narrowest) {
  PlanGraph closed = WithDoorsClosed(plan, narrowest * 0.5);
  DropDeadEnds(closed);
  std::vector<HalfWall> halves = HalfWallsOf(closed);
  std::vector<PlanRoom> rooms;
  for (std::size_t i = 0; i < halves.size(); ++i) {
    std::vector<Vector2d> outline;
    for (int half = static_cast<int>(i); !halves[half].visited; half = halves[half].next) {
      halves[half].visited = true;
      outline.push_back(closed.corners[halves[half].from].point);
    }
    // The face around a connected part runs the other way.
    if (outline.size() < 3 || AreaOf(outline) <= 0) continue;
    if (2 * AreaOf(outline) / CircumferenceOf(outline) < narrowest) continue;
    rooms.push_back({.outline = std::move(outline), .name = ""});
  }
  std::stable_sort(rooms.begin(), rooms.end(),
                   [](const PlanRoom& a, const PlanRoom& b) { return AreaOf(a.outline) > AreaOf(b.outline); });
  return rooms;
}

double NarrowestRoom(const PlanGraph& plan) {
  double thickest = 0;
  for (const PlanWall& wall : plan.walls) thickest = std::max(thickest, wall.thickness);
  return std::max(thickest, 1e-3 * WallLength(plan) / std::sqrt(static_cast<double>(plan.walls.size())));
}

}  // namespace enfilade::prior
