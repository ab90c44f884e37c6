// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/plotted_building.h"

#include <algorithm>
#include <utility>

#include "fmt/format.h"

namespace enfilade::simulator {

PlottedBuilding::PlottedBuilding(const std::string& name, std::uint64_t seed, std::uint64_t noise_seed)
    : noise(noise_seed) {
  campus.name = name;
  campus.texture_seed = seed;
  campus.levels["ground"] = 0.0;
  campus.textures["plain"] = Texture{};
  campus.wall_thickness = noise.Uniform(0.08, 0.25);
}

void PlottedBuilding::AddArea(const std::string& id, AreaKind kind, std::vector<Eigen::Vector2d> outline) {
  double twice_area = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& next = outline[(i + 1) % outline.size()];
    twice_area += outline[i].x() * next.y() - outline[i].y() * next.x();
  }
  if (twice_area < 0.0) std::reverse(outline.begin(), outline.end());
  Area area;
  area.id = id;
  area.kind = kind;
  area.level = "ground";
  area.outline = std::move(outline);
  area.texture = "plain";
  campus.areas.push_back(std::move(area));
}

void PlottedBuilding::AddDoor(const SolidWall& wall) {
  const double length = (wall.to - wall.from).norm();
  const Eigen::Vector2d along = (wall.to - wall.from) / length;
  const double clear = campus.wall_thickness / 2.0;  // to the face of the wall across
  const double width =
      noise.Uniform(wall.narrowest, std::max(wall.narrowest + 0.05, std::min(wall.widest, length - 2.0 * clear - 0.1)));
  const double slack = std::max(0.0, length - 2.0 * clear - width);
  double at = clear + noise.Uniform(0.0, slack);
  const bool flush = noise.Chance(0.5);
  if (flush) at = noise.Chance(0.5) ? clear : clear + slack;
  Door door;
  door.id = fmt::format("d{}", campus.doors.size());
  door.level = "ground";
  door.a = wall.from + at * along;
  door.b = door.a + width * along;
  if (noise.Chance(wall.closed)) door.state = DoorState::kClosed;
  if (!flush && door.state == DoorState::kOpen && noise.Chance(wall.leaf)) {
    std::swap(door.a, door.b);
    const bool left = along.x() * wall.into.y() - along.y() * wall.into.x() > 0.0;
    door.leaf = (left ? -1.0 : 1.0) * noise.Uniform(1.5, 1.8);
  }
  campus.doors.push_back(std::move(door));
}

void PlottedBuilding::AddDoorOrDouble(const SolidWall& wall) {
  constexpr double kChance = 0.4;
  constexpr double kNarrowest = 1.8;  // m
  constexpr double kWidest = 3.2;
  constexpr double kBeside = 0.5;  // m of wall, at least
  SolidWall around = wall;
  if ((wall.to - wall.from).norm() > kWidest + kBeside && noise.Chance(kChance)) {
    around = {.from = wall.from, .to = wall.to, .widest = kWidest, .narrowest = kNarrowest};
  }
  AddDoor(around);
}

void PlottedBuilding::Furnish(const Plot& plot) {
  const int pieces = static_cast<int>(plot.width * plot.depth * 0.12);
  for (int i = 0; i < pieces; ++i) {
    const double width = noise.Uniform(0.4, 2.0);
    const double depth = noise.Uniform(0.4, 1.2);
    const double slack = plot.width - width - 0.2;
    if (plot.depth < depth || slack < 0.0) continue;
    const bool at_end = noise.Chance(0.5);
    const double u = at_end ? 0.1 + (noise.Chance(0.5) ? 0.0 : slack) : noise.Uniform(0.1, 0.1 + slack);
    const double v = at_end ? noise.Uniform(0.0, plot.depth - depth) : plot.depth - depth - 0.1;
    AddBox(plot, u, v, width, depth, noise.Uniform(0.5, 2.0));
  }
}

void PlottedBuilding::AddBox(const Plot& plot, double u, double v, double width, double depth, double top) {
  constexpr double kDoorMargin = 0.6;  // m
  constexpr double kBoxMargin = 0.7;   // m
  const Eigen::Vector2d one = plot.At(u, v);
  const Eigen::Vector2d other = plot.At(u + width, v + depth);
  const Eigen::Vector2d lower = one.cwiseMin(other);
  const Eigen::Vector2d upper = one.cwiseMax(other);
  const auto distance = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    const Eigen::Vector2d out = (lower - from.cwiseMax(to)).cwiseMax(from.cwiseMin(to) - upper).cwiseMax(0.0);
    return out.norm();
  };
  for (const Door& door : campus.doors) {
    if (distance(door.a, door.b) < kDoorMargin) return;
  }
  for (const Box& box : campus.boxes) {
    if (distance(box.outline[0], box.outline[2]) < kBoxMargin) return;
  }
  Box box;
  box.level = "ground";
  box.outline = RectangleOutline(lower.x(), lower.y(), upper.x() - lower.x(), upper.y() - lower.y());
  box.top = top;
  campus.boxes.push_back(std::move(box));
}

}  // namespace enfilade::simulator
