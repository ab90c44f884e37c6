// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/random_suites.h"

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/campus/building_tour.h"
#include "core/base/noise.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace enfilade::simulator {
namespace {

// The ground of a suite in a frame of its own: u along the corridor, v away from it.
struct Plot {
  Eigen::Vector2d origin;
  Eigen::Vector2d u;
  Eigen::Vector2d v;
  double width;
  double depth;

  Eigen::Vector2d At(double along, double away) const { return origin + along * u + away * v; }
};

// A wall that a door is cut into.
struct SolidWall {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  double widest;        // m, of the door
  double closed = 0.0;  // how likely the door is closed,
  double leaf = 0.0;    // and how likely its leaf stands on the side `into`, hinged away from `from`
  Eigen::Vector2d into = Eigen::Vector2d::Zero();
};

class Suites {
 public:
  explicit Suites(std::uint64_t seed) : noise_(Mix(seed, 0x5017E5)) {
    campus_.name = fmt::format("suites-{}", seed);
    campus_.texture_seed = seed;
    campus_.levels["ground"] = 0.0;
    campus_.textures["plain"] = Texture{};
    campus_.wall_thickness = noise_.Uniform(0.08, 0.25);
  }

  absl::StatusOr<Campus> Build() && {
    const double length = noise_.Uniform(13.0, 20.0);
    const double breadth = noise_.Uniform(1.6, 2.6);
    AddArea("corridor", AreaKind::kCorridor, {{0.0, 0.0}, {length, 0.0}, {length, breadth}, {0.0, breadth}});
    for (const bool above : {true, false}) AddRow(above, length, breadth);
    AddHall(length, breadth);
    if (noise_.Chance(0.5)) AddPillars(length, breadth);
    for (const Plot& plot : to_furnish_) Furnish(plot);
    ENFILADE_RETURN_IF_ERROR(PlanTour(campus_));
    return std::move(campus_);
  }

 private:
  void AddArea(const std::string& id, AreaKind kind, std::vector<Eigen::Vector2d> outline) {
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
    campus_.areas.push_back(std::move(area));
  }

  // The rooms on one side of the corridor.
  void AddRow(bool above, double length, double breadth) {
    constexpr double kNarrowest = 3.4;  // m
    double x = 0.0;
    for (int i = 0; x < length - 1e-6; ++i) {
      double width = noise_.Uniform(kNarrowest, 6.0);
      if (length - x - width < kNarrowest) width = length - x;
      const bool mirrored = noise_.Chance(0.5);
      const Plot plot{{mirrored ? x + width : x, above ? breadth : 0.0},
                      {mirrored ? -1.0 : 1.0, 0.0},
                      {0.0, above ? 1.0 : -1.0},
                      width,
                      noise_.Uniform(4.5, 7.5)};
      const std::string id = fmt::format("{}{}", above ? "n" : "s", i);
      const double kind = noise_.Uniform();
      if (kind < 0.5) {
        AddSuite(id, plot);
      } else if (kind < 0.75) {
        AddRoomWithStore(id, plot);
      } else {
        AddOpenRoom(id, plot);
      }
      x += width;
    }
  }

  // A bathroom beside the entrance.
  void AddSuite(const std::string& id, const Plot& plot) {
    const double width = noise_.Uniform(1.5, std::min(2.6, plot.width - 1.4));
    const double depth = noise_.Uniform(1.5, 2.5);
    AddArea(id + "-bathroom", AreaKind::kRoom,
            {plot.At(0.0, 0.0), plot.At(width, 0.0), plot.At(width, depth), plot.At(0.0, depth)});
    AddArea(id, AreaKind::kRoom,
            {plot.At(width, 0.0), plot.At(plot.width, 0.0), plot.At(plot.width, plot.depth), plot.At(0.0, plot.depth),
             plot.At(0.0, depth), plot.At(width, depth)});
    AddDoor({plot.At(width, 0.0), plot.At(plot.width, 0.0), 1.2, 0.0, 0.3, plot.v});
    if (noise_.Chance(0.7)) {
      AddDoor({plot.At(width, 0.0), plot.At(width, depth), 1.2, 0.08});
    } else {
      AddDoor({plot.At(0.0, depth), plot.At(width, depth), 1.2, 0.08});
    }
    AddFixture(plot.At(0.0, 0.0), plot);
    to_furnish_.push_back({plot.At(0.0, depth + 0.8), plot.u, plot.v, plot.width, plot.depth - depth - 0.8});
  }

  // A store in a far corner.
  void AddRoomWithStore(const std::string& id, const Plot& plot) {
    const double width = noise_.Uniform(1.3, 2.3);
    const double near = plot.depth - noise_.Uniform(1.3, 2.3);
    AddArea(id + "-store", AreaKind::kRoom,
            {plot.At(0.0, near), plot.At(width, near), plot.At(width, plot.depth), plot.At(0.0, plot.depth)});
    AddArea(id, AreaKind::kRoom,
            {plot.At(0.0, 0.0), plot.At(plot.width, 0.0), plot.At(plot.width, plot.depth), plot.At(width, plot.depth),
             plot.At(width, near), plot.At(0.0, near)});
    AddDoor({plot.At(0.0, 0.0), plot.At(plot.width, 0.0), 1.6, 0.0, 0.3, plot.v});
    if (noise_.Chance(0.5)) {
      AddDoor({plot.At(width, plot.depth), plot.At(width, near), 1.2, 0.08});
    } else {
      AddDoor({plot.At(0.0, near), plot.At(width, near), 1.2, 0.08});
    }
    to_furnish_.push_back({plot.At(0.0, 0.8), plot.u, plot.v, plot.width, near - 1.6});
  }

  // With an alcove, a partition or shelves.
  void AddOpenRoom(const std::string& id, const Plot& plot) {
    std::vector<Eigen::Vector2d> outline{plot.At(0.0, 0.0), plot.At(plot.width, 0.0), plot.At(plot.width, plot.depth)};
    if (noise_.Chance(0.5)) {
      const double width = noise_.Uniform(1.1, 2.4);
      const double from = noise_.Chance(0.5) ? 0.0 : noise_.Uniform(0.2, plot.width - width - 0.2);
      const double depth = plot.depth + noise_.Uniform(0.6, 1.8);
      outline.push_back(plot.At(from + width, plot.depth));
      outline.push_back(plot.At(from + width, depth));
      outline.push_back(plot.At(from, depth));
      if (from > 0.0) outline.push_back(plot.At(from, plot.depth));
    }
    if (outline.size() != 6) outline.push_back(plot.At(0.0, plot.depth));
    AddArea(id, AreaKind::kRoom, outline);
    AddDoor({plot.At(0.0, 0.0), plot.At(plot.width, 0.0), 1.6, 0.0, 0.3, plot.v});
    if (noise_.Chance(0.5)) {
      AddPartition(plot);
    } else {
      AddShelves(plot);
    }
  }

  // A free-standing wall, or one that ends before the opposite wall.
  void AddPartition(const Plot& plot) {
    const double at = noise_.Uniform(0.4, 0.65) * plot.depth;
    const double gap = noise_.Uniform(1.6, std::min(2.6, plot.width - 1.2));
    const double other = plot.width > 4.4 && noise_.Chance(0.4) ? noise_.Uniform(1.0, 1.4) : 0.0;
    Wall wall;
    wall.level = "ground";
    wall.points = {plot.At(std::min(other, plot.width - gap - 0.8), at), plot.At(plot.width - gap, at)};
    wall.thickness = noise_.Uniform(0.05, 0.2);
    campus_.walls.push_back(std::move(wall));
  }

  void AddShelves(const Plot& plot) {
    const double deep = noise_.Uniform(0.35, 0.6);
    const double aisle = noise_.Uniform(0.9, 1.5);
    const double begin = noise_.Chance(0.5) ? 0.1 : aisle;
    for (double at = 1.5; at + deep < plot.depth - 0.9; at += deep + aisle) {
      AddBox(plot, begin, at, plot.width - aisle - begin, deep, noise_.Uniform(0.9, 2.2));
    }
  }

  void AddHall(double length, double breadth) {
    const double depth = noise_.Uniform(5.0, 9.0);
    const double south = -noise_.Uniform(0.0, 4.0);
    const double north = breadth + noise_.Uniform(0.0, 4.0);
    AddArea("hall", AreaKind::kRoom,
            {{length, south}, {length + depth, south}, {length + depth, north}, {length, north}});
    AddDoor({{length, 0.0}, {length, breadth}, breadth - 0.4});
    const Plot plot{{length, south}, {0.0, 1.0}, {1.0, 0.0}, north - south, depth};
    to_furnish_.push_back({plot.At(0.0, 1.5), plot.u, plot.v, plot.width, depth - 1.5});
  }

  // Half of the doors stand at an end of their wall.
  void AddDoor(const SolidWall& wall) {
    const double length = (wall.to - wall.from).norm();
    const Eigen::Vector2d along = (wall.to - wall.from) / length;
    const double clear = campus_.wall_thickness / 2.0;  // to the face of the wall across
    const double width = noise_.Uniform(0.75, std::max(0.8, std::min(wall.widest, length - 2.0 * clear - 0.1)));
    const double slack = std::max(0.0, length - 2.0 * clear - width);
    double at = clear + noise_.Uniform(0.0, slack);
    const bool flush = noise_.Chance(0.5);
    if (flush) at = noise_.Chance(0.5) ? clear : clear + slack;
    Door door;
    door.id = fmt::format("d{}", campus_.doors.size());
    door.level = "ground";
    door.a = wall.from + at * along;
    door.b = door.a + width * along;
    if (noise_.Chance(wall.closed)) door.state = DoorState::kClosed;
    if (!flush && door.state == DoorState::kOpen && noise_.Chance(wall.leaf)) {
      std::swap(door.a, door.b);
      const bool left = along.x() * wall.into.y() - along.y() * wall.into.x() > 0.0;
      door.leaf = (left ? -1.0 : 1.0) * noise_.Uniform(1.5, 1.8);
    }
    campus_.doors.push_back(std::move(door));
  }

  // Along the corridor's walls.
  void AddPillars(double length, double breadth) {
    const Plot corridor{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, length, breadth};
    for (double at = noise_.Uniform(1.0, 5.0); at < length - 1.0; at += noise_.Uniform(3.0, 6.0)) {
      const double out = noise_.Uniform(0.1, std::min(0.6, breadth - 1.2));
      AddBox(corridor, at, noise_.Chance(0.5) ? 0.0 : breadth - out, noise_.Uniform(0.2, 0.5), out, 3.0);
    }
  }

  // In a bathroom's corner.
  void AddFixture(const Eigen::Vector2d& corner, const Plot& plot) {
    const Plot at{corner, plot.u, plot.v, 0.0, 0.0};
    AddBox(at, 0.1, 0.1, noise_.Uniform(0.4, 0.7), noise_.Uniform(0.4, 0.7), noise_.Uniform(0.5, 1.0));
  }

  // A few pieces at the walls: beds, desks, wardrobes.
  void Furnish(const Plot& plot) {
    const int pieces = static_cast<int>(plot.width * plot.depth * 0.12);
    for (int i = 0; i < pieces; ++i) {
      const double width = noise_.Uniform(0.4, 2.0);
      const double depth = noise_.Uniform(0.4, 1.2);
      const double slack = plot.width - width - 0.2;
      if (plot.depth < depth || slack < 0.0) continue;
      const bool at_end = noise_.Chance(0.5);
      const double u = at_end ? 0.1 + (noise_.Chance(0.5) ? 0.0 : slack) : noise_.Uniform(0.1, 0.1 + slack);
      const double v = at_end ? noise_.Uniform(0.0, plot.depth - depth) : plot.depth - depth - 0.1;
      AddBox(plot, u, v, width, depth, noise_.Uniform(0.5, 2.0));
    }
  }

  // Unless a door is near or the way past another box would be narrow.
  void AddBox(const Plot& plot, double u, double v, double width, double depth, double top) {
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
    for (const Door& door : campus_.doors) {
      if (distance(door.a, door.b) < kDoorMargin) return;
    }
    for (const Box& box : campus_.boxes) {
      if (distance(box.outline[0], box.outline[2]) < kBoxMargin) return;
    }
    Box box;
    box.level = "ground";
    box.outline = RectangleOutline(lower.x(), lower.y(), upper.x() - lower.x(), upper.y() - lower.y());
    box.top = top;
    campus_.boxes.push_back(std::move(box));
  }

  Noise noise_;
  Campus campus_;
  std::vector<Plot> to_furnish_;
};

}  // namespace

absl::StatusOr<Campus> RandomSuites(std::uint64_t seed) { return Suites(seed).Build(); }

}  // namespace enfilade::simulator
