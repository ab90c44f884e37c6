// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>
#include <utility>

#include "client/simulator/campus/building_draft.h"
#include "fmt/format.h"

namespace enfilade::simulator {
namespace {

// A stretch of wall between two spaces in which a door may be cut.
struct DoorWall {
  Eigen::Vector2d begin;
  Eigen::Vector2d along;  // unit vector
  double length;          // m
  int from;               // spaces
  int to;
  Eigen::Vector2d normal;  // from `from` to `to`
  double max_width = 2.0;  // m, of the door
};

class Layout {
 public:
  explicit Layout(BuildingDraft& draft) : draft_(draft), noise_(draft.noise), campus_(draft.campus) {}

  void Run() {
    const double length = noise_.Uniform(14.0, 24.0);
    const double breadth = noise_.Uniform(1.7, 3.0);
    const int corridor = AddSpace("corridor", AreaKind::kCorridor, {0.0, 0.0, length, breadth});
    for (const bool above : {true, false}) AddRooms(corridor, above, length, breadth);
    const double hall = noise_.Uniform(6.0, 10.0);
    const int lobby =
        AddSpace("hall", AreaKind::kRoom, {length, breadth / 2.0 - hall / 2.0, noise_.Uniform(5.0, 9.0), hall});
    AddDoor({{length, 0.0}, north_, breadth, corridor, lobby, east_, breadth - 0.6});
    const double outside = draft_.space(lobby).x + draft_.space(lobby).width;
    const int yard = AddSpace("yard", AreaKind::kOutdoor, {outside, -14.0, 26.0, 28.0 + breadth});
    AddDoor({{outside, breadth / 2.0 - hall / 2.0}, north_, hall, lobby, yard, east_});
  }

 private:
  // A row of rooms along the corridor's northern (`above`) or southern wall.
  void AddRooms(int corridor, bool above, double length, double breadth) {
    double x = 0.0;
    int last = -1;
    double last_depth = 0.0;
    for (int i = 0; x < length - 3.0; ++i) {
      double width = noise_.Uniform(3.2, 7.0);
      if (length - x - width < 3.2) width = length - x;
      const double depth = noise_.Uniform(3.0, 6.5);
      const int room = AddSpace(fmt::format("{}{}", above ? "n" : "s", i), AreaKind::kRoom,
                                {x, above ? breadth : -depth, width, depth});
      AddDoor({{x, above ? breadth : 0.0}, east_, width, corridor, room, above ? north_ : Eigen::Vector2d(-north_)});
      if (last >= 0 && noise_.Chance(0.5)) {
        const double shared = std::min(depth, last_depth);
        AddDoor({{x, above ? breadth : -shared}, north_, shared, last, room, east_});
      }
      last = room;
      last_depth = depth;
      x += width;
    }
  }

  int AddSpace(const std::string& id, AreaKind kind, const Rect& rect) {
    Area area;
    area.id = id;
    area.kind = kind;
    area.level = "ground";
    area.outline = RectangleOutline(rect.x, rect.y, rect.width, rect.height);
    area.texture = "plain";
    if (kind == AreaKind::kOutdoor) area.wall_height = 1.8;
    campus_.areas.push_back(std::move(area));
    draft_.spaces.push_back(rect);
    return static_cast<int>(draft_.spaces.size()) - 1;
  }

  // Cuts a door into the wall if it is long enough.
  void AddDoor(const DoorWall& wall) {
    const BuildingOptions& options = draft_.options;
    const double clear = campus_.wall_thickness / 2.0 + 0.05;  // to the corner's wall
    const double widest = std::min({options.max_width, wall.max_width, wall.length - 2.0 * clear - 0.1});
    if (widest < options.min_width) return;
    Door door;
    door.id = fmt::format("d{}", campus_.doors.size());
    door.level = "ground";
    const double width = noise_.Uniform(options.min_width, widest);
    const double slack = wall.length - 2.0 * clear - width;
    double at = clear + (slack > 0.6 ? noise_.Uniform(0.3, slack - 0.3) : slack / 2.0);
    const bool corner = noise_.Chance(options.beside_wall);
    if (corner) at = noise_.Chance(0.5) ? clear : clear + slack;
    door.a = wall.begin + at * wall.along;
    door.b = door.a + width * wall.along;
    const double kind = noise_.Uniform();
    if (kind < 0.08) door.state = DoorState::kClosed;
    if (kind > 0.95) door.state = DoorState::kGlass;
    if (door.state == DoorState::kOpen && noise_.Chance(options.leaf)) AddLeaf(wall, corner, door);
    if (!corner && noise_.Chance(options.glass_panel)) AddPane(door, wall);
    if (door.state == DoorState::kOpen) {
      draft_.passable.push_back({campus_.doors.size(), {wall.from, wall.to}, wall.normal, 0});
    }
    campus_.doors.push_back(door);
  }

  // The leaf stands open into the space `to`, hinged so that it does not block the straight way. There is no room for
  // it in a corner.
  void AddLeaf(const DoorWall& wall, bool corner, Door& door) {
    const double turn = wall.normal.dot(Eigen::Vector2d(-wall.along.y(), wall.along.x())) > 0.0 ? 1.0 : -1.0;
    door.leaf = turn * noise_.Uniform(1.6, 1.85);
    if (noise_.Chance(0.5)) {
      std::swap(door.a, door.b);
      door.leaf = -*door.leaf;
    }
    if (corner) door.leaf.reset();
  }

  // One metre of the wall beside a door is a pane of glass.
  void AddPane(const Door& door, const DoorWall& wall) {
    const double end = std::max(wall.along.dot(door.a - wall.begin), wall.along.dot(door.b - wall.begin));
    if (end + 1.4 > wall.length) return;
    Door cut;
    cut.id = fmt::format("pane{}", campus_.doors.size());
    cut.level = "ground";
    cut.opening = true;
    cut.a = wall.begin + (end + 0.15) * wall.along;
    cut.b = wall.begin + (end + 1.15) * wall.along;
    cut.state = DoorState::kGlass;
    campus_.doors.push_back(cut);
  }

  const Eigen::Vector2d east_{1.0, 0.0};
  const Eigen::Vector2d north_{0.0, 1.0};

  BuildingDraft& draft_;
  Noise& noise_;
  Campus& campus_;
};

}  // namespace

void LayOutSpaces(BuildingDraft& draft) { Layout(draft).Run(); }

}  // namespace enfilade::simulator
