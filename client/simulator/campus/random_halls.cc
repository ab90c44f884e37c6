// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/random_halls.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/campus/building_tour.h"
#include "client/simulator/campus/plotted_building.h"
#include "core/base/noise.h"
#include "core/base/status_macros.h"
#include "core/geometry/segments.h"
#include "fmt/format.h"

namespace enfilade::simulator {
namespace {

using Polyline = std::vector<Eigen::Vector2d>;

constexpr double kWay = 1.0;        // m, around what stands in the hall, and before doors
constexpr double kOpenWidth = 1.8;  // m, at least, between a wall that reaches into the hall and what it points at
constexpr double kWide = 2.8;       // m: an opening that could still be a door's
constexpr double kFar = 100.0;      // m, more than any hall
constexpr double kInset = 0.05;     // m: a wall at the side of the hall begins so far inside the line of that side
constexpr int kTries = 20;          // to place a part

class Halls {
 public:
  explicit Halls(std::uint64_t seed)
      : building_(fmt::format("halls-{}", seed), seed, Mix(seed, 0x4A115)),
        noise_(building_.noise),
        campus_(building_.campus) {}

  absl::StatusOr<Campus> Build() && {
    width_ = noise_.Uniform(11.0, 20.0);
    depth_ = noise_.Uniform(7.0, 13.0);
    DrawOutline();
    const int first = noise_.Below(4);
    for (int side = 0; side < 4; ++side) {
      if (side == first || noise_.Chance(0.4)) AddRooms(side);
    }
    for (std::size_t i = 0; i < outline_.size(); ++i) {
      bounds_.push_back({outline_[i], outline_[(i + 1) % outline_.size()]});
    }
    const int parts = static_cast<int>(width_ * depth_ / noise_.Uniform(20.0, 50.0)) + 1;
    for (int i = 0; i < parts; ++i) {
      for (int tries = 0; tries < kTries; ++tries) {
        if (AddPart()) break;
      }
    }
    building_.AddArea("hall", AreaKind::kRoom, outline_);
    AddDesks();
    for (const Plot& plot : to_furnish_) building_.Furnish(plot);
    ENFILADE_RETURN_IF_ERROR(PlanTour(campus_));
    return std::move(campus_);
  }

 private:
  struct Segment {
    Eigen::Vector2d a;
    Eigen::Vector2d b;
  };

  // The hall's corners, of which some are cut off, and its sides in the same order.
  void DrawOutline() {
    const Polyline corners = {{0.0, 0.0}, {width_, 0.0}, {width_, depth_}, {0.0, depth_}};
    double cuts[4] = {};
    for (double& cut : cuts) cut = noise_.Chance(0.3) ? noise_.Uniform(1.5, depth_ / 3.0) : 0.0;
    for (int i = 0; i < 4; ++i) {
      const auto side = static_cast<std::size_t>(i);
      const Eigen::Vector2d& corner = corners[side];
      const Eigen::Vector2d& next = corners[(side + 1) % 4];
      const Eigen::Vector2d along = (next - corner).normalized();
      const Eigen::Vector2d begin = corner + cuts[side] * along;
      const Eigen::Vector2d end = next - cuts[(side + 1) % 4] * along;
      outline_.push_back(begin);
      if (cuts[(side + 1) % 4] > 0.0) outline_.push_back(end);
      sides_.push_back({begin, along, {along.y(), -along.x()}, (end - begin).norm(), 0.0});
    }
  }

  // A row of rooms outside the hall, each with a door to it.
  void AddRooms(int side) {
    constexpr double kNarrowest = 2.6;  // m
    constexpr double kRoundFrom = 3.0;
    const Plot& front = sides_[static_cast<std::size_t>(side)];
    double last_depth = 0.0;
    Polyline round;  // the walls that are not straight
    for (double x = 0.0; x < front.width - kNarrowest;) {
      double width = noise_.Uniform(kNarrowest, 5.5);
      if (front.width - x - width < kNarrowest) width = front.width - x;
      const Plot plot{front.At(x, 0.0), front.u, front.v, width, noise_.Uniform(2.6, 5.5)};
      x += width;
      if (noise_.Chance(0.2)) {
        last_depth = 0.0;
        continue;
      }
      Polyline room_front;
      if (plot.width > kRoundFrom && noise_.Chance(0.25)) room_front = DrawRoundFront(plot);
      Polyline room = plot.Outline();
      room.insert(std::next(room.begin()), room_front.begin(), room_front.end());
      building_.AddArea(fmt::format("room-{}", campus_.areas.size()), AreaKind::kRoom, room);
      if (room_front.empty()) {
        building_.AddDoorOrDouble({plot.At(0.0, 0.0), plot.At(plot.width, 0.0), 1.8, 0.05, 0.3, plot.v});
      } else {
        round.push_back(plot.At(0.0, 0.0));
        round.insert(round.end(), room_front.begin(), room_front.end());
        round.push_back(plot.At(plot.width, 0.0));
      }
      const double shared = std::min(last_depth, plot.depth);
      if (shared > 0.0 && noise_.Chance(0.25)) {
        building_.AddDoor({plot.At(0.0, 0.5), plot.At(0.0, shared), 1.4, 0.1, 0.3, plot.u});
      }
      last_depth = plot.depth;
      to_furnish_.push_back({plot.At(0.0, 0.8), plot.u, plot.v, plot.width, plot.depth - 0.8});
    }
    const auto begin = std::find(outline_.begin(), outline_.end(), front.origin);
    outline_.insert(std::next(begin), round.begin(), round.end());
  }

  // A room's wall that bulges into the hall, without its ends, and a door in it.
  Polyline DrawRoundFront(const Plot& plot) {
    constexpr double kPiece = 0.6;  // m, about
    const double sag = noise_.Uniform(0.1, 0.3) * plot.width;
    const double door = noise_.Uniform(0.9, std::min(2.8, 0.6 * plot.width));
    const double begin = noise_.Uniform(0.3, plot.width - door - 0.3);
    const auto at = [&](double u) {
      const double share = u / plot.width;
      return plot.At(u, -4.0 * sag * share * (1.0 - share));
    };
    Polyline wall;
    const auto divide = [&](double from, double to) {
      const int pieces = std::max(1, static_cast<int>(std::lround((to - from) / kPiece)));
      for (int i = 1; i <= pieces; ++i) wall.push_back(at(from + (to - from) * i / pieces));
    };
    divide(0.0, begin);
    wall.push_back(at(begin + door));
    divide(begin + door, plot.width);
    wall.pop_back();
    const double length = (at(begin + door) - at(begin)).norm();
    building_.AddDoor(
        {.from = at(begin), .to = at(begin + door), .widest = length, .narrowest = std::max(0.75, length - 0.4)});
    return wall;
  }

  // False: it did not fit where it was tried.
  bool AddPart() {
    const double kind = noise_.Uniform();
    if (kind < 0.35) return AddScreen();
    if (kind < 0.6) return AddSpur();
    if (kind < 0.75) return AddKiosk();
    if (kind < 0.9) return AddBooth();
    return AddPillars();
  }

  // A place in the hall and a direction, mostly along a wall.
  Plot Place(double width, double depth) {
    const double yaw = noise_.Chance(0.8) ? M_PI_2 * noise_.Below(4) : noise_.Uniform(0.0, 2.0 * M_PI);
    const Eigen::Vector2d u(std::cos(yaw), std::sin(yaw));
    const Eigen::Vector2d middle(noise_.Uniform(0.0, width_), noise_.Uniform(0.0, depth_));
    const Eigen::Vector2d v(-u.y(), u.x());
    return {middle - width / 2.0 * u - depth / 2.0 * v, u, v, width, depth};
  }

  // A free-standing wall, straight or with a corner. Half of them nearly divide what they stand in.
  bool AddScreen() {
    Plot plot = Place(noise_.Uniform(1.5, 7.0), noise_.Uniform(0.6, 2.5));
    if (noise_.Chance(0.5)) {
      const double before = Sight(plot.origin, -plot.u) - noise_.Uniform(kWay, kWide);
      const double behind = Sight(plot.origin, plot.u) - noise_.Uniform(kWay, kWide);
      plot.origin -= before * plot.u;
      plot.width = before + behind;
      if (plot.width < 1.5 || plot.width > 9.0) return false;
      return AddWall({plot.At(0.0, 0.0), plot.At(plot.width, 0.0)});
    }
    Polyline points = {plot.At(0.0, 0.0), plot.At(plot.width, 0.0)};
    if (noise_.Chance(0.25)) points.push_back(plot.At(plot.width, plot.depth));
    return AddWall(points);
  }

  // A wall that reaches into the hall from one of its sides, straight or with a hook. Half of them nearly divide it.
  bool AddSpur() {
    const Plot& side = sides_[static_cast<std::size_t>(noise_.Below(4))];
    const double at = noise_.Uniform(0.0, side.width);
    double length = noise_.Uniform(0.8, 5.0);
    if (noise_.Chance(0.5)) length = Sight(side.At(at, -0.1), -side.v) - noise_.Uniform(kOpenWidth, kWide);
    if (length < 0.8 || length > 7.0) return false;
    Polyline points = {side.At(at, -kInset), side.At(at, -length)};
    if (noise_.Chance(0.3)) points.push_back(side.At(at + noise_.Uniform(-2.0, 2.0), -length));
    return AddWall(points, &side);
  }

  // m, from the point to the nearest wall in this direction; 0 if there is none.
  double Sight(const Eigen::Vector2d& from, const Eigen::Vector2d& direction) const {
    double nearest = kFar;
    for (const Segment& bound : bounds_) {
      const Eigen::Vector2d to = from + kFar * direction;
      if (!SegmentsCross(from, to, bound.a, bound.b)) continue;
      const double one = std::abs(SideOf(from, to, bound.a));
      const double other = std::abs(SideOf(from, to, bound.b));
      const Eigen::Vector2d hit = bound.a + one / (one + other) * (bound.b - bound.a);
      nearest = std::min(nearest, (hit - from).norm());
    }
    return nearest < kFar ? nearest : 0.0;
  }

  // Three walls, free-standing or at a side of the hall.
  bool AddBooth() {
    const double width = noise_.Uniform(1.4, 3.0);
    const double depth = noise_.Uniform(1.0, 2.4);
    if (noise_.Chance(0.5)) {
      const Plot& side = sides_[static_cast<std::size_t>(noise_.Below(4))];
      const double at = noise_.Uniform(0.0, side.width - width);
      const Polyline one = {side.At(at, -kInset), side.At(at, -depth)};
      const Polyline other = {side.At(at + width, -kInset), side.At(at + width, -depth)};
      return Fits(one, &side) && Fits(other, &side) && AddWall(one, &side) && AddWall(other, &side);
    }
    const Plot plot = Place(width, depth);
    return AddWall({plot.At(0.0, depth), plot.At(0.0, 0.0), plot.At(width, 0.0), plot.At(width, depth)});
  }

  // A small room in the hall. From some a wall goes on.
  bool AddKiosk() {
    const Plot plot = Place(noise_.Uniform(1.6, 3.2), noise_.Uniform(1.5, 2.8));
    Polyline outline = plot.Outline();
    outline.push_back(outline[0]);
    const Polyline wing = {plot.At(0.0, 0.0), plot.At(-noise_.Uniform(1.5, 4.5), 0.0)};
    const bool winged = noise_.Chance(0.5);
    if (!Fits(outline) || (winged && !Fits(wing))) return false;
    if (winged) AddWall(wing);
    Bound(outline);
    outline.pop_back();
    building_.AddArea(fmt::format("kiosk-{}", campus_.areas.size()), AreaKind::kRoom, outline);
    building_.AddDoor({outline[2], outline[3], 1.3, 0.1, 0.0});
    return true;
  }

  // A row that no wall joins.
  bool AddPillars() {
    const Plot plot = Place(noise_.Uniform(3.0, 9.0), noise_.Uniform(0.25, 0.6));
    const double step = noise_.Uniform(1.5, 3.5);
    bool any = false;
    for (double u = 0.0; u <= plot.width; u += step) {
      const Polyline outline = {plot.At(u, 0.0), plot.At(u + plot.depth, 0.0), plot.At(u + plot.depth, plot.depth),
                                plot.At(u, plot.depth)};
      if (!Fits(outline)) continue;
      Bound(outline);
      Box box;
      box.level = "ground";
      box.outline = outline;
      box.top = 3.0;
      campus_.boxes.push_back(std::move(box));
      any = true;
    }
    return any;
  }

  bool AddWall(const Polyline& points, const Plot* at = nullptr) {
    if (!Fits(points, at)) return false;
    Wall wall;
    wall.level = "ground";
    wall.points = points;
    wall.top = noise_.Chance(0.3) ? noise_.Uniform(1.2, 2.0) : 3.0;
    wall.thickness = noise_.Uniform(0.05, 0.2);
    campus_.walls.push_back(std::move(wall));
    Bound(points);
    return true;
  }

  void Bound(const Polyline& points) {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) bounds_.push_back({points[i], points[i + 1]});
  }

  // Whether the walls along the points lie in the hall, with a way around them. `at`: the side that they stand at.
  bool Fits(const Polyline& points, const Plot* at = nullptr) const {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const Eigen::Vector2d& a = points[i];
      const Eigen::Vector2d& b = points[i + 1];
      if (!Contains(outline_, b) || (!at && !Contains(outline_, a))) return false;
      for (const Door& door : campus_.doors) {
        if (SegmentDistance(a, b, door.a, door.b) < kWay) return false;
      }
      for (const Segment& bound : bounds_) {
        const bool is_own = at && IsOn(*at, bound);
        const bool ends_before = i + 2 == points.size() && at;
        if (!is_own && SegmentDistance(a, b, bound.a, bound.b) < kWay) return false;
        if (!is_own && ends_before && SegmentDistance(b, b + kOpenWidth * (b - a).normalized(), bound.a, bound.b) < 0.3)
          return false;
        if (is_own && i > 0 && SegmentDistance(a, b, bound.a, bound.b) < kWay) return false;
      }
    }
    return true;
  }

  static bool IsOn(const Plot& side, const Segment& bound) {
    return std::abs((bound.a - side.origin).dot(side.v)) < 1e-6 && std::abs((bound.b - side.origin).dot(side.v)) < 1e-6;
  }

  // Rows of desks in what is left of the hall.
  void AddDesks() {
    if (noise_.Chance(0.3)) return;
    const Plot hall{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, width_, depth_};
    const int rows = noise_.Below(5) + 1;
    for (int row = 0; row < rows; ++row) {
      const double length = noise_.Uniform(1.2, 4.0);
      const double deep = noise_.Uniform(0.6, 1.6);
      const bool along = noise_.Chance(0.5);
      const double w = along ? length : deep;
      const double d = along ? deep : length;
      const double u = noise_.Uniform(0.3, width_ - w - 0.3);
      const double v = noise_.Uniform(0.3, depth_ - d - 0.3);
      const Polyline outline = {hall.At(u, v), hall.At(u + w, v), hall.At(u + w, v + d), hall.At(u, v + d),
                                hall.At(u, v)};
      if (Fits(outline)) building_.AddBox(hall, u, v, w, d, noise_.Uniform(0.7, 1.5));
    }
  }

  PlottedBuilding building_;
  Noise& noise_;
  Campus& campus_;
  double width_ = 0.0;  // m, of the hall
  double depth_ = 0.0;
  Polyline outline_;
  std::vector<Plot> sides_;      // of the hall: u along the side, v out of the hall
  std::vector<Segment> bounds_;  // walls, pillars and the outline of the hall
  std::vector<Plot> to_furnish_;
};

}  // namespace

absl::StatusOr<Campus> RandomHalls(std::uint64_t seed) { return Halls(seed).Build(); }

}  // namespace enfilade::simulator
