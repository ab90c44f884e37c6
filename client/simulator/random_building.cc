// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/random_building.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "client/simulator/sensors/noise.h"
#include "fmt/format.h"

namespace enfilade::simulator {
namespace {

constexpr double kMargin = 0.45;  // m between the robot's way and whatever stands there

struct Rect {
  double x = 0.0, y = 0.0, width = 0.0, height = 0.0;

  bool Holds(const Eigen::Vector2d& p, double margin) const {
    return p.x() >= x + margin && p.x() <= x + width - margin && p.y() >= y + margin && p.y() <= y + height - margin;
  }
};

struct Passable {
  std::size_t door;  // in the campus
  int spaces[2];
  Eigen::Vector2d normal;  // from spaces[0] to spaces[1]
  int used = 0;
};

double DistanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d edge = b - a;
  const double t = edge.squaredNorm() > 0.0 ? std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - t * edge).norm();
}

class Builder {
 public:
  Builder(std::uint64_t seed, const BuildingOptions& options) : options_(options), noise_(Mix(seed, 0xB01D)) {
    campus_.name = fmt::format("random-{}", seed);
    campus_.texture_seed = seed;
    campus_.levels["ground"] = 0.0;
    campus_.textures["plain"] = Texture{};
    campus_.wall_thickness = noise_.Uniform(0.1, 0.3);
  }

  Campus Build() && {
    LayOut();
    PlanRoute();
    for (Door& door : campus_.doors) {
      if (door.leaf && LeafInTheWay(door)) door.leaf.reset();
    }
    for (std::size_t i = 0; i < spaces_.size(); ++i) Furnish(i);
    return std::move(campus_);
  }

 private:
  int AddSpace(const std::string& id, AreaKind kind, const Rect& rect) {
    Area area;
    area.id = id;
    area.kind = kind;
    area.level = "ground";
    area.outline = RectangleOutline(rect.x, rect.y, rect.width, rect.height);
    area.texture = "plain";
    if (kind == AreaKind::kOutdoor) area.wall_height = 1.8;
    campus_.areas.push_back(std::move(area));
    spaces_.push_back(rect);
    return static_cast<int>(spaces_.size()) - 1;
  }

  // A door in the wall from `begin` along `on` (unit), free for `length` m, between two spaces.
  void AddDoor(const Eigen::Vector2d& begin, const Eigen::Vector2d& on, double length, int from, int to,
               const Eigen::Vector2d& normal, double widest) {
    const double clear = campus_.wall_thickness / 2.0 + 0.05;  // to the corner's wall
    widest = std::min({options_.max_width, widest, length - 2.0 * clear - 0.1});
    if (widest < options_.min_width) return;
    Door door;
    door.id = fmt::format("d{}", campus_.doors.size());
    door.level = "ground";
    const double width = noise_.Uniform(options_.min_width, widest);
    const double slack = length - 2.0 * clear - width;
    double at = clear + (slack > 0.6 ? noise_.Uniform(0.3, slack - 0.3) : slack / 2.0);
    const bool corner = noise_.Chance(options_.beside_wall);
    if (corner) at = noise_.Chance(0.5) ? clear : clear + slack;
    door.a = begin + at * on;
    door.b = door.a + width * on;
    const double kind = noise_.Uniform();
    if (kind < 0.08) door.state = DoorState::kClosed;
    if (kind > 0.95) door.state = DoorState::kGlass;
    if (door.state == DoorState::kOpen && noise_.Chance(options_.leaf)) {
      // Into the space `to`, hinged so that it does not stand in the way of whoever goes straight.
      const double turn = normal.dot(Eigen::Vector2d(-on.y(), on.x())) > 0.0 ? 1.0 : -1.0;
      door.leaf = turn * noise_.Uniform(1.6, 1.85);
      if (noise_.Chance(0.5)) {
        std::swap(door.a, door.b);
        door.leaf = -*door.leaf;
      }
      if (corner) door.leaf.reset();  // no room for it
    }
    if (!corner && noise_.Chance(options_.glass_panel)) AddPane(door, begin, on, length);
    if (door.state == DoorState::kOpen) passable_.push_back({campus_.doors.size(), {from, to}, normal, 0});
    campus_.doors.push_back(door);
  }

  // The wall beside a door is a pane of glass for a metre.
  void AddPane(const Door& door, const Eigen::Vector2d& begin, const Eigen::Vector2d& on, double length) {
    const double end = std::max(on.dot(door.a - begin), on.dot(door.b - begin));
    if (end + 1.4 > length) return;
    Door cut;
    cut.id = fmt::format("pane{}", campus_.doors.size());
    cut.level = "ground";
    cut.opening = true;
    cut.a = begin + (end + 0.15) * on;
    cut.b = begin + (end + 1.15) * on;
    cut.state = DoorState::kGlass;
    campus_.doors.push_back(cut);
  }

  void LayOut() {
    const double length = noise_.Uniform(14.0, 24.0);
    const double breadth = noise_.Uniform(1.7, 3.0);
    const int corridor = AddSpace("corridor", AreaKind::kCorridor, {0.0, 0.0, length, breadth});
    const Eigen::Vector2d east(1.0, 0.0);
    const Eigen::Vector2d north(0.0, 1.0);
    for (const bool above : {true, false}) {
      double x = 0.0;
      int last = -1;
      double last_depth = 0.0;
      for (int i = 0; x < length - 3.0; ++i) {
        double width = noise_.Uniform(3.2, 7.0);
        if (length - x - width < 3.2) width = length - x;
        const double depth = noise_.Uniform(3.0, 6.5);
        const int room = AddSpace(fmt::format("{}{}", above ? "n" : "s", i), AreaKind::kRoom,
                                  {x, above ? breadth : -depth, width, depth});
        AddDoor({x, above ? breadth : 0.0}, east, width, corridor, room, above ? north : Eigen::Vector2d(-north), 2.0);
        if (last >= 0 && noise_.Chance(0.5)) {
          const double shared = std::min(depth, last_depth);
          AddDoor({x, above ? breadth : -shared}, north, shared, last, room, east, 2.0);
        }
        last = room;
        last_depth = depth;
        x += width;
      }
    }
    const double hall = noise_.Uniform(6.0, 10.0);
    const int lobby =
        AddSpace("hall", AreaKind::kRoom, {length, breadth / 2.0 - hall / 2.0, noise_.Uniform(5.0, 9.0), hall});
    AddDoor({length, 0.0}, north, breadth, corridor, lobby, east, breadth - 0.6);
    const double outside = spaces_[static_cast<std::size_t>(lobby)].x + spaces_[static_cast<std::size_t>(lobby)].width;
    const int yard = AddSpace("yard", AreaKind::kOutdoor, {outside, -14.0, 26.0, 28.0 + breadth});
    AddDoor({outside, breadth / 2.0 - hall / 2.0}, north, hall, lobby, yard, east, 2.0);
  }

  // A point before the door on the side of `space`, from which the way through is `angle` off the normal: as far away
  // as the space allows.
  std::optional<Eigen::Vector2d> Beside(const Passable& passable, int space, double angle) const {
    const Door& door = campus_.doors[passable.door];
    const Eigen::Vector2d away = passable.spaces[0] == space ? Eigen::Vector2d(-passable.normal) : passable.normal;
    const Eigen::Vector2d ray(std::cos(angle) * away.x() - std::sin(angle) * away.y(),
                              std::sin(angle) * away.x() + std::cos(angle) * away.y());
    for (double way = 1.6; way >= 0.6; way -= 0.1) {
      const Eigen::Vector2d point = door.middle() + way * ray;
      if (spaces_[static_cast<std::size_t>(space)].Holds(point, 0.4)) return point;
    }
    return std::nullopt;
  }

  void Go(const Eigen::Vector2d& point) {
    RouteStep step;
    step.point = point;
    campus_.robots.back().route.push_back(step);
  }

  // The way from `space` through the door: at an angle that the robot's width allows on both sides.
  void GoThrough(const Passable& passable, int space) {
    const Door& door = campus_.doors[passable.door];
    const int other = passable.spaces[0] == space ? passable.spaces[1] : passable.spaces[0];
    double angle = noise_.Uniform(-options_.max_incidence, options_.max_incidence);
    while (door.width() * std::cos(angle) - campus_.wall_thickness * std::sin(std::abs(angle)) <
               2.0 * options_.robot_half_width + 0.1 &&
           std::abs(angle) > 0.05) {
      angle *= 0.8;
    }
    if (door.leaf) angle *= 0.3;
    for (int attempt = 0; attempt < 12; ++attempt, angle *= 0.75) {
      const auto before = Beside(passable, space, angle);
      const auto behind = Beside(passable, other, angle);
      if (!before || !behind) continue;
      Go(*before);
      Go(*behind);
      return;
    }
    Go(*Beside(passable, space, 0.0));
    Go(*Beside(passable, other, 0.0));
  }

  Eigen::Vector2d Inside(int space) {
    const Rect& rect = spaces_[static_cast<std::size_t>(space)];
    const double margin = std::min({1.0, rect.width / 2.0 - 0.2, rect.height / 2.0 - 0.2});
    double width = rect.width;
    if (rect.width > 24.0) width = 12.0;  // the yard: not all of it
    return {noise_.Uniform(rect.x + margin, rect.x + width - margin),
            noise_.Uniform(rect.y + margin, rect.y + rect.height - margin)};
  }

  void PlanRoute() {
    Robot robot;
    robot.id = "robot";
    robot.level = "ground";
    campus_.robots.push_back(robot);
    int space = passable_.empty()
                    ? 0
                    : passable_[static_cast<std::size_t>(noise_.Below(static_cast<int>(passable_.size())))].spaces[0];
    Go(Inside(space));
    for (int i = 0; i < options_.passages; ++i) {
      std::vector<Passable*> choices;
      for (Passable& passable : passable_) {
        if (passable.spaces[0] != space && passable.spaces[1] != space) continue;
        if (!Beside(passable, passable.spaces[0], 0.0) || !Beside(passable, passable.spaces[1], 0.0)) continue;
        choices.push_back(&passable);
      }
      if (choices.empty()) break;
      int least = choices[0]->used;
      for (const Passable* choice : choices) least = std::min(least, choice->used);
      std::erase_if(choices, [&](const Passable* choice) { return choice->used > least; });
      Passable& chosen = *choices[static_cast<std::size_t>(noise_.Below(static_cast<int>(choices.size())))];
      ++chosen.used;
      GoThrough(chosen, space);
      space = chosen.spaces[0] == space ? chosen.spaces[1] : chosen.spaces[0];
      Go(Inside(space));
    }
    if (campus_.robots.back().route.size() < 2) Go(Inside(space));
  }

  double DistanceToRoute(const Eigen::Vector2d& point) const {
    double nearest = 1e9;
    const std::vector<RouteStep>& route = campus_.robots.back().route;
    for (std::size_t i = 1; i < route.size(); ++i) {
      nearest = std::min(nearest, DistanceToSegment(point, route[i - 1].point, route[i].point));
    }
    return nearest;
  }
  // From the outline, sampled every 10 cm.
  double DistanceToRoute(const std::vector<Eigen::Vector2d>& outline) const {
    double nearest = 1e9;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector2d edge = outline[(i + 1) % outline.size()] - outline[i];
      const int pieces = 1 + static_cast<int>(edge.norm() / 0.1);
      for (int k = 0; k < pieces; ++k)
        nearest = std::min(nearest, DistanceToRoute(outline[i] + edge * (double(k) / pieces)));
    }
    return nearest;
  }
  // A box may not stand in a door's way either, nor beside it like a wall.
  bool NearDoor(const std::vector<Eigen::Vector2d>& outline, double distance) const {
    for (const Door& door : campus_.doors) {
      for (const Eigen::Vector2d& corner : outline) {
        if (DistanceToSegment(corner, door.a, door.b) < distance) return true;
      }
    }
    return false;
  }
  bool TryBox(const Rect& rect, double yaw, double top, double margin, double from_door) {
    Box box;
    box.level = "ground";
    box.outline = RectangleOutline(rect.x, rect.y, rect.width, rect.height, yaw);
    box.top = top;
    if (DistanceToRoute(box.outline) < margin || NearDoor(box.outline, from_door)) return false;
    campus_.boxes.push_back(std::move(box));
    return true;
  }

  bool LeafInTheWay(const Door& door) const {
    const Eigen::Vector2d gap = door.b - door.a;
    const double c = std::cos(*door.leaf);
    const double s = std::sin(*door.leaf);
    const Eigen::Vector2d leaf(c * gap.x() - s * gap.y(), s * gap.x() + c * gap.y());
    for (double t = 0.1; t <= 1.0; t += 0.1) {
      if (DistanceToRoute(Eigen::Vector2d(door.a + t * leaf)) < 0.3) return true;
    }
    return false;
  }

  void Furnish(std::size_t index) {
    const Rect& rect = spaces_[index];
    const bool corridor = campus_.areas[index].kind == AreaKind::kCorridor;
    const double area = std::min(rect.width * rect.height, 200.0);
    // Cupboards stand along corridors' walls; in rooms things stand about.
    const int boxes = static_cast<int>(area * (corridor ? 0.5 : 1.0) * options_.clutter);
    for (int i = 0; i < boxes; ++i) {
      const double width = noise_.Uniform(0.3, 1.6);
      const double depth = corridor ? noise_.Uniform(0.25, 0.6) : noise_.Uniform(0.3, 1.0);
      Rect box{noise_.Uniform(rect.x + 0.1, rect.x + rect.width - width - 0.1), 0.0, width, depth};
      box.y = noise_.Uniform(rect.y + 0.1, rect.y + rect.height - depth - 0.1);
      if (corridor) box.y = noise_.Chance(0.5) ? rect.y + 0.1 : rect.y + rect.height - depth - 0.1;
      TryBox(box, corridor ? 0.0 : noise_.Uniform(-0.5, 0.5), noise_.Uniform(0.65, 1.9), kMargin, 0.6);
    }
    if (noise_.Chance(options_.narrows)) AddNarrows(rect);
    const int people = static_cast<int>(area * options_.people + noise_.Uniform());
    for (int i = 0; i < people; ++i) AddPerson(rect);
  }

  // Two boxes on both sides of the way, a door's width apart.
  void AddNarrows(const Rect& rect) {
    const std::vector<RouteStep>& route = campus_.robots.back().route;
    for (std::size_t i = 1; i < route.size(); ++i) {
      const Eigen::Vector2d leg = route[i].point - route[i - 1].point;
      const Eigen::Vector2d middle = (route[i].point + route[i - 1].point) / 2.0;
      if (leg.norm() < 2.0 || !rect.Holds(middle, 1.2)) continue;
      const Eigen::Vector2d aside = Eigen::Vector2d(-leg.y(), leg.x()).normalized();
      const double half = noise_.Uniform(0.5, 0.9);
      for (const double sign : {-1.0, 1.0}) {
        const double side = noise_.Uniform(0.3, 0.8);
        const Eigen::Vector2d at = middle + sign * (half + side / 2.0) * aside;
        TryBox({at.x() - side / 2.0, at.y() - side / 2.0, side, side}, std::atan2(leg.y(), leg.x()),
               noise_.Uniform(0.7, 1.9), 0.4, 0.6);
      }
      return;
    }
  }

  void AddPerson(const Rect& rect) {
    Person person;
    person.level = "ground";
    for (int attempt = 0; attempt < 20; ++attempt) {
      person.path.clear();
      for (int i = 0; i < 2; ++i) {
        person.path.emplace_back(noise_.Uniform(rect.x + 0.4, rect.x + std::min(rect.width, 12.0) - 0.4),
                                 noise_.Uniform(rect.y + 0.4, rect.y + rect.height - 0.4));
      }
      bool clear = true;
      for (double t = 0.0; t <= 1.0; t += 0.05) {
        const Eigen::Vector2d at = person.path[0] + t * (person.path[1] - person.path[0]);
        clear = clear && DistanceToRoute(at) > 0.6;
      }
      if (!clear) continue;
      person.speed = noise_.Uniform(0.3, 1.3);
      person.phase = noise_.Uniform(0.0, 60.0);
      campus_.people.push_back(person);
      return;
    }
  }

  BuildingOptions options_;
  Noise noise_;
  Campus campus_;
  std::vector<Rect> spaces_;  // as campus_.areas
  std::vector<Passable> passable_;
};

}  // namespace

Campus RandomBuilding(std::uint64_t seed, const BuildingOptions& options) { return Builder(seed, options).Build(); }

}  // namespace enfilade::simulator
