// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/plan/campus_plan.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "client/simulator/world/door_gaps.h"
#include "core/prior/plan/planar.h"

namespace enfilade::simulator {
namespace {

constexpr double kWeld = 0.05;        // m
constexpr double kLowWall = 1.5;      // m: what is lower is furniture to a plan
constexpr double kLongEnough = 0.02;  // m

Eigen::Vector2d ToSheet(const Eigen::Vector2d& point_campus) { return {point_campus.x(), -point_campus.y()}; }

class PlanDrafter {
 public:
  PlanDrafter(const Campus& campus, const std::string& level) : campus_(campus), level_(level) {}

  prior::PlanGraph Run() && {
    for (const Area& area : campus_.areas) {
      if (area.level == level_) AddArea(area);
    }
    for (const Wall& wall : campus_.walls) {
      if (wall.level != level_ || wall.bottom > 0.5 || wall.top < kLowWall) continue;
      for (std::size_t i = 0; i + 1 < wall.points.size(); ++i) {
        AddWall(wall.points[i], wall.points[i + 1], wall.thickness);
      }
    }
    for (const Door& door : campus_.doors) {
      if (door.level == level_ && !door.opening) plan_.doors.push_back({ToSheet(door.a), ToSheet(door.b)});
    }
    plan_.metres_per_unit = 1.0;
    return prior::Planarise(plan_, kWeld);
  }

 private:
  void AddArea(const Area& area) {
    std::vector<Eigen::Vector2d> outline;
    for (const Eigen::Vector2d& corner : area.outline) outline.push_back(ToSheet(corner));
    std::reverse(outline.begin(), outline.end());
    for (std::size_t i = 0; area.walled && i < area.outline.size(); ++i) {
      AddWall(area.outline[i], area.outline[(i + 1) % area.outline.size()], campus_.wall_thickness);
    }
    if (campus_.FindLift(area.id) != nullptr) {
      plan_.shafts.push_back({prior::ShaftKind::kLift, std::move(outline), area.id});
    } else if (area.indoor()) {
      plan_.rooms.push_back({std::move(outline), area.id});
    }
  }

  void AddWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness) {
    const double length = (to - from).norm();
    if (length < kLongEnough) return;
    const Eigen::Vector2d on = (to - from) / length;
    std::vector<DoorGap> gaps = DoorGapsOf(campus_, level_, from, to);
    std::sort(gaps.begin(), gaps.end(), [](const DoorGap& a, const DoorGap& b) { return a.begin < b.begin; });
    double begin = 0.0;
    for (const DoorGap& gap : gaps) {
      AddPiece(from + begin * on, from + std::max(begin, gap.begin) * on, thickness);
      begin = std::max(begin, gap.end);
    }
    if (begin < length) AddPiece(from + begin * on, to, thickness);
  }

  void AddPiece(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness) {
    if ((to - from).norm() < kLongEnough) return;
    const int first = static_cast<int>(plan_.corners.size());
    plan_.corners.push_back({ToSheet(from)});
    plan_.corners.push_back({ToSheet(to)});
    plan_.walls.push_back({.from = first, .to = first + 1, .thickness = thickness});
  }

  const Campus& campus_;
  const std::string& level_;
  prior::PlanGraph plan_;
};

}  // namespace

prior::PlanGraph PlanOf(const Campus& campus, const std::string& level) { return PlanDrafter(campus, level).Run(); }

Eigen::Vector2d ToCampus(const Eigen::Vector2d& point_sheet) { return {point_sheet.x(), -point_sheet.y()}; }

}  // namespace enfilade::simulator
