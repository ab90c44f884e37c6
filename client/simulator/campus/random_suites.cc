// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/random_suites.h"

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/campus/building_tour.h"
#include "client/simulator/campus/plotted_building.h"
#include "core/base/noise.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace enfilade::simulator {
namespace {

class Suites {
 public:
  explicit Suites(std::uint64_t seed)
      : building_(fmt::format("suites-{}", seed), seed, Mix(seed, 0x5017E5)),
        noise_(building_.noise),
        campus_(building_.campus) {}

  absl::StatusOr<Campus> Build() && {
    const double length = noise_.Uniform(13.0, 20.0);
    const double breadth = noise_.Uniform(1.6, 2.6);
    std::vector<Eigen::Vector2d> corridor{{0.0, breadth}, {0.0, 0.0}};
    AddRow(false, length, breadth, corridor);
    corridor.insert(corridor.end(), {{length, 0.0}, {length, breadth}});
    std::vector<Eigen::Vector2d> north;
    AddRow(true, length, breadth, north);
    corridor.insert(corridor.end(), north.rbegin(), north.rend());
    building_.AddArea("corridor", AreaKind::kCorridor, corridor);
    AddHall(length, breadth);
    if (noise_.Chance(0.5)) AddPillars(length, breadth);
    for (const Plot& plot : to_furnish_) building_.Furnish(plot);
    ENFILADE_RETURN_IF_ERROR(PlanTour(campus_));
    return std::move(campus_);
  }

 private:
  static constexpr double kDeepest = 7.5;  // m

  // The rooms on one side of the corridor, and perhaps a corridor that branches off, whose corners `corridor` gets.
  void AddRow(bool above, double length, double breadth, std::vector<Eigen::Vector2d>& corridor) {
    constexpr double kNarrowest = 3.4;  // m
    double x = 0.0;
    for (int i = 0; x < length - 1e-6; ++i) {
      const double side = above ? 1.0 : -1.0;
      if (corridor.size() <= 2 && length - x > 3.0 * kNarrowest && noise_.Chance(0.3)) {
        x += AddBranch(fmt::format("{}{}", above ? "n" : "s", i), {x, above ? breadth : 0.0}, side, corridor);
        continue;
      }
      double width = noise_.Uniform(kNarrowest, 6.0);
      if (length - x - width < kNarrowest) width = length - x;
      const bool mirrored = noise_.Chance(0.5);
      const Plot plot{{mirrored ? x + width : x, above ? breadth : 0.0},
                      {mirrored ? -1.0 : 1.0, 0.0},
                      {0.0, side},
                      width,
                      noise_.Uniform(4.5, kDeepest)};
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

  // A corridor that branches off and leads to a room at its end, or to rooms beside it, as to a lift. Returns how much
  // of the row it takes.
  double AddBranch(const std::string& id, const Eigen::Vector2d& at, double side,
                   std::vector<Eigen::Vector2d>& corridor) {
    const double width = noise_.Uniform(1.4, 2.8);
    const bool to_end = noise_.Chance(0.4);
    const double before = !to_end && noise_.Chance(0.6) ? noise_.Uniform(1.8, 3.4) : 0.0;
    const double behind = !to_end && (before == 0.0 || noise_.Chance(0.3)) ? noise_.Uniform(1.8, 3.4) : 0.0;
    const double depth = to_end ? kDeepest + noise_.Uniform(0.2, 2.0) : noise_.Uniform(2.4, 7.0);
    const Plot branch{at + Eigen::Vector2d(before, 0.0), {1.0, 0.0}, {0.0, side}, width, depth};
    const Eigen::Vector2d a = branch.At(0.0, depth);
    const Eigen::Vector2d b = branch.At(width, depth);
    corridor.insert(corridor.end(), {branch.At(0.0, 0.0), a, b, branch.At(width, 0.0)});
    if (before > 0.0) AddRoomBesideBranch(id + "-a", {branch.origin, {-1.0, 0.0}, branch.v, before, depth});
    if (behind > 0.0) AddRoomBesideBranch(id + "-b", {branch.At(width, 0.0), branch.u, branch.v, behind, depth});
    if (to_end) {
      const double left = noise_.Uniform(0.3, 2.0);
      const double right = width + noise_.Uniform(0.3, 2.0);
      const double end = depth + noise_.Uniform(2.6, 5.0);
      building_.AddArea(
          id, AreaKind::kRoom,
          {branch.At(-left, depth), a, b, branch.At(right, depth), branch.At(right, end), branch.At(-left, end)});
      building_.AddDoor({a, b, 1.6, 0.0, 0.3, branch.v});
    }
    return before + width + behind;
  }

  // Its door is in the wall where the plot's u is 0.
  void AddRoomBesideBranch(const std::string& id, const Plot& plot) {
    building_.AddArea(id, AreaKind::kRoom, plot.Outline());
    building_.AddDoor({plot.At(0.0, 0.0), plot.At(0.0, plot.depth), 1.6, 0.0, 0.3, plot.u});
  }

  // A bathroom beside the entrance.
  void AddSuite(const std::string& id, const Plot& plot) {
    const double width = noise_.Uniform(1.5, std::min(2.6, plot.width - 1.4));
    const double depth = noise_.Uniform(1.5, 2.5);
    building_.AddArea(id + "-bathroom", AreaKind::kRoom,
                      {plot.At(0.0, 0.0), plot.At(width, 0.0), plot.At(width, depth), plot.At(0.0, depth)});
    building_.AddArea(id, AreaKind::kRoom,
                      {plot.At(width, 0.0), plot.At(plot.width, 0.0), plot.At(plot.width, plot.depth),
                       plot.At(0.0, plot.depth), plot.At(0.0, depth), plot.At(width, depth)});
    building_.AddDoor({plot.At(width, 0.0), plot.At(plot.width, 0.0), 1.2, 0.0, 0.3, plot.v});
    if (noise_.Chance(0.7)) {
      building_.AddDoor({plot.At(width, 0.0), plot.At(width, depth), 1.2, 0.08});
    } else {
      building_.AddDoor({plot.At(0.0, depth), plot.At(width, depth), 1.2, 0.08});
    }
    AddFixture(plot.At(0.0, 0.0), plot);
    to_furnish_.push_back({plot.At(0.0, depth + 0.8), plot.u, plot.v, plot.width, plot.depth - depth - 0.8});
  }

  // A store in a far corner.
  void AddRoomWithStore(const std::string& id, const Plot& plot) {
    const double width = noise_.Uniform(1.3, 2.3);
    const double near = plot.depth - noise_.Uniform(1.3, 2.3);
    building_.AddArea(id + "-store", AreaKind::kRoom,
                      {plot.At(0.0, near), plot.At(width, near), plot.At(width, plot.depth), plot.At(0.0, plot.depth)});
    building_.AddArea(id, AreaKind::kRoom,
                      {plot.At(0.0, 0.0), plot.At(plot.width, 0.0), plot.At(plot.width, plot.depth),
                       plot.At(width, plot.depth), plot.At(width, near), plot.At(0.0, near)});
    building_.AddDoorOrDouble({plot.At(0.0, 0.0), plot.At(plot.width, 0.0), 1.6, 0.0, 0.3, plot.v});
    if (noise_.Chance(0.5)) {
      building_.AddDoor({plot.At(width, plot.depth), plot.At(width, near), 1.2, 0.08});
    } else {
      building_.AddDoor({plot.At(0.0, near), plot.At(width, near), 1.2, 0.08});
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
    building_.AddArea(id, AreaKind::kRoom, outline);
    building_.AddDoorOrDouble({plot.At(0.0, 0.0), plot.At(plot.width, 0.0), 1.6, 0.0, 0.3, plot.v});
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
      building_.AddBox(plot, begin, at, plot.width - aisle - begin, deep, noise_.Uniform(0.9, 2.2));
    }
  }

  void AddHall(double length, double breadth) {
    const double depth = noise_.Uniform(5.0, 9.0);
    const double south = -noise_.Uniform(0.0, 4.0);
    const double north = breadth + noise_.Uniform(0.0, 4.0);
    building_.AddArea("hall", AreaKind::kRoom,
                      {{length, south}, {length + depth, south}, {length + depth, north}, {length, north}});
    building_.AddDoor({{length, 0.0}, {length, breadth}, breadth - 0.4});
    const Plot plot{{length, south}, {0.0, 1.0}, {1.0, 0.0}, north - south, depth};
    to_furnish_.push_back({plot.At(0.0, 1.5), plot.u, plot.v, plot.width, depth - 1.5});
  }

  // Along the corridor's walls.
  void AddPillars(double length, double breadth) {
    const Plot corridor{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, length, breadth};
    for (double at = noise_.Uniform(1.0, 5.0); at < length - 1.0; at += noise_.Uniform(3.0, 6.0)) {
      const double out = noise_.Uniform(0.1, std::min(0.6, breadth - 1.2));
      building_.AddBox(corridor, at, noise_.Chance(0.5) ? 0.0 : breadth - out, noise_.Uniform(0.2, 0.5), out, 3.0);
    }
  }

  // In a bathroom's corner.
  void AddFixture(const Eigen::Vector2d& corner, const Plot& plot) {
    const Plot at{corner, plot.u, plot.v, 0.0, 0.0};
    building_.AddBox(at, 0.1, 0.1, noise_.Uniform(0.4, 0.7), noise_.Uniform(0.4, 0.7), noise_.Uniform(0.5, 1.0));
  }

  PlottedBuilding building_;
  Noise& noise_;
  Campus& campus_;
  std::vector<Plot> to_furnish_;
};

}  // namespace

absl::StatusOr<Campus> RandomSuites(std::uint64_t seed) { return Suites(seed).Build(); }

}  // namespace enfilade::simulator
