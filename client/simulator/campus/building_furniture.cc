// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "client/simulator/campus/building_draft.h"
#include "core/geometry/segments.h"

namespace enfilade::simulator {
namespace {

class Furnisher {
 public:
  explicit Furnisher(BuildingDraft& draft)
      : options_(draft.options), route_(draft.route()), noise_(draft.noise), campus_(draft.campus) {}

  void RemoveBlockingLeaves() {
    for (Door& door : campus_.doors) {
      if (door.leaf && LeafBlocksRoute(door)) door.leaf.reset();
    }
  }

  // Cupboards stand along the walls of corridors, furniture anywhere in rooms.
  void Furnish(const Rect& rect, bool corridor) {
    const double area = std::min(rect.width * rect.height, 200.0);
    const int boxes = static_cast<int>(area * (corridor ? 0.5 : 1.0) * options_.clutter);
    for (int i = 0; i < boxes; ++i) AddFurniture(rect, corridor);
    if (noise_.Chance(options_.narrows)) AddNarrows(rect);
    const int people = static_cast<int>(area * options_.people + noise_.Uniform());
    for (int i = 0; i < people; ++i) AddPerson(rect);
  }

 private:
  struct Placement {
    Rect rect;
    double yaw = 0.0;
    double top = 1.0;
    double route_margin = 0.45;  // m between the robot's way and the box
  };

  double DistanceToRoute(const Eigen::Vector2d& point) const {
    double nearest = 1e9;
    for (std::size_t i = 1; i < route_.size(); ++i) {
      nearest = std::min(nearest, DistanceToSegment(point, route_[i - 1].point, route_[i].point));
    }
    return nearest;
  }
  // From the outline, sampled every 10 cm.
  double DistanceToRoute(const std::vector<Eigen::Vector2d>& outline) const {
    double nearest = 1e9;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector2d edge = outline[(i + 1) % outline.size()] - outline[i];
      const int pieces = 1 + static_cast<int>(edge.norm() / 0.1);
      for (int k = 0; k < pieces; ++k) {
        nearest = std::min(nearest, DistanceToRoute(outline[i] + edge * (double(k) / pieces)));
      }
    }
    return nearest;
  }
  // A box must not stand in a doorway, nor beside it like a wall.
  bool NearDoor(const std::vector<Eigen::Vector2d>& outline, double distance) const {
    for (const Door& door : campus_.doors) {
      for (const Eigen::Vector2d& corner : outline) {
        if (DistanceToSegment(corner, door.a, door.b) < distance) return true;
      }
    }
    return false;
  }
  void TryBox(const Placement& placement) {
    constexpr double kDoorMargin = 0.6;  // m
    const Rect& rect = placement.rect;
    Box box;
    box.level = "ground";
    box.outline = RectangleOutline(rect.x, rect.y, rect.width, rect.height, placement.yaw);
    box.top = placement.top;
    if (DistanceToRoute(box.outline) < placement.route_margin || NearDoor(box.outline, kDoorMargin)) return;
    campus_.boxes.push_back(std::move(box));
  }

  bool LeafBlocksRoute(const Door& door) const {
    const Eigen::Vector2d gap = door.b - door.a;
    const double c = std::cos(*door.leaf);
    const double s = std::sin(*door.leaf);
    const Eigen::Vector2d leaf(c * gap.x() - s * gap.y(), s * gap.x() + c * gap.y());
    for (double t = 0.1; t <= 1.0; t += 0.1) {
      if (DistanceToRoute(Eigen::Vector2d(door.a + t * leaf)) < 0.3) return true;
    }
    return false;
  }

  void AddFurniture(const Rect& rect, bool corridor) {
    const double width = noise_.Uniform(0.3, 1.6);
    const double depth = corridor ? noise_.Uniform(0.25, 0.6) : noise_.Uniform(0.3, 1.0);
    Placement placement;
    placement.rect = {noise_.Uniform(rect.x + 0.1, rect.x + rect.width - width - 0.1), 0.0, width, depth};
    placement.rect.y = noise_.Uniform(rect.y + 0.1, rect.y + rect.height - depth - 0.1);
    if (corridor) placement.rect.y = noise_.Chance(0.5) ? rect.y + 0.1 : rect.y + rect.height - depth - 0.1;
    placement.top = noise_.Uniform(0.65, 1.9);
    if (!corridor) placement.yaw = noise_.Uniform(-0.5, 0.5);
    TryBox(placement);
  }

  // Two boxes on both sides of the way, as far apart as a door's jambs.
  void AddNarrows(const Rect& rect) {
    for (std::size_t i = 1; i < route_.size(); ++i) {
      const Eigen::Vector2d leg = route_[i].point - route_[i - 1].point;
      const Eigen::Vector2d middle = (route_[i].point + route_[i - 1].point) / 2.0;
      if (leg.norm() < 2.0 || !rect.Holds(middle, 1.2)) continue;
      const Eigen::Vector2d aside = Eigen::Vector2d(-leg.y(), leg.x()).normalized();
      const double half = noise_.Uniform(0.5, 0.9);
      for (const double sign : {-1.0, 1.0}) {
        const double side = noise_.Uniform(0.3, 0.8);
        const Eigen::Vector2d at = middle + sign * (half + side / 2.0) * aside;
        Placement placement;
        placement.rect = {at.x() - side / 2.0, at.y() - side / 2.0, side, side};
        placement.yaw = std::atan2(leg.y(), leg.x());
        placement.top = noise_.Uniform(0.7, 1.9);
        placement.route_margin = 0.4;
        TryBox(placement);
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
        const double y = noise_.Uniform(rect.y + 0.4, rect.y + rect.height - 0.4);
        const double x = noise_.Uniform(rect.x + 0.4, rect.x + std::min(rect.width, 12.0) - 0.4);
        person.path.emplace_back(x, y);
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

  const BuildingOptions& options_;
  const std::vector<RouteStep>& route_;
  Noise& noise_;
  Campus& campus_;
};

}  // namespace

void Furnish(BuildingDraft& draft) {
  Furnisher furnisher(draft);
  furnisher.RemoveBlockingLeaves();
  for (std::size_t i = 0; i < draft.spaces.size(); ++i) {
    furnisher.Furnish(draft.spaces[i], draft.campus.areas[i].kind == AreaKind::kCorridor);
  }
}

}  // namespace enfilade::simulator
