// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/plan/deformed_plan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "client/simulator/plan/campus_plan.h"
#include "core/base/noise.h"

namespace enfilade::simulator {
namespace {

using Eigen::Vector2d;

constexpr double kBorder = 30.0;  // px around the plan
constexpr double kStrip = 0.5;    // m: lines nearer to each other bound one strip
constexpr double kKeep = 0.3;     // of its shortest wall, a corner moves at most; m, a wall beside a shifted door keeps
constexpr double kJambReach = 0.3;  // m: a corner so near to a door's end is its jamb
constexpr double kShortest = 1.0;   // m, of invented walls
constexpr double kLongest = 3.0;    // m
constexpr double kClearance = 0.4;  // m, to any other wall
constexpr int kAttempts = 50;       // per invented wall

// A strictly rising function that is linear between the lines of walls.
class Stretch {
 public:
  Stretch(std::vector<double> lines, double sigma, Noise& noise) {
    std::sort(lines.begin(), lines.end());
    for (const double line : lines) {
      if (!lines_.empty() && line - lines_.back() < kStrip) continue;
      if (!lines_.empty()) to_.push_back(to_.back() + (line - lines_.back()) * std::exp(sigma * noise.Normal()));
      if (lines_.empty()) to_.push_back(line);
      lines_.push_back(line);
    }
  }
  double operator()(double x) const {
    if (lines_.size() < 2) return x;
    const auto after = std::upper_bound(lines_.begin() + 1, lines_.end() - 1, x) - lines_.begin();
    const auto i = static_cast<std::size_t>(after);
    const double share = (x - lines_[i - 1]) / (lines_[i] - lines_[i - 1]);
    return to_[i - 1] + share * (to_[i] - to_[i - 1]);
  }

 private:
  std::vector<double> lines_;
  std::vector<double> to_;
};

double DistanceToWall(const prior::PlanGraph& plan, const prior::PlanWall& wall, const Vector2d& point) {
  const Vector2d a = plan.corners[static_cast<std::size_t>(wall.from)].point;
  const Vector2d ab = plan.corners[static_cast<std::size_t>(wall.to)].point - a;
  const double t = std::clamp((point - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (point - a - t * ab).norm();
}

class Deformer {
 public:
  Deformer(const prior::PlanGraph& built, const PlanDeformation& deformation)
      : deformation_(deformation), noise_(deformation.seed), plan_(built), original_(built) {}

  DeformedPlan Run() {
    LeaveOut();
    Invent();
    DropUnused();
    for (const prior::PlanCorner& corner : plan_.corners) result_.corners.push_back(ToCampus(corner.point));
    const std::vector<Vector2d> moves = Moves();
    const auto stretch = Stretches();
    const auto stretched = [&](const Vector2d& p) -> Vector2d { return {stretch[0](p.x()), stretch[1](p.y())}; };
    const Eigen::Matrix2d linear = Linear();
    const auto to_sheet = [&](const Vector2d& p) -> Vector2d { return linear * stretched(p); };
    for (prior::PlanDoor& door : plan_.doors) {
      for (Vector2d* end : {&door.from, &door.to}) {
        const int jamb = JambAt(*end);
        *end = to_sheet(*end + (jamb >= 0 ? moves[static_cast<std::size_t>(jamb)] : Vector2d::Zero()));
      }
    }
    for (std::size_t i = 0; i < plan_.corners.size(); ++i) {
      plan_.corners[i].point = to_sheet(plan_.corners[i].point + moves[i]);
    }
    for (prior::PlanRoom& room : plan_.rooms) {
      for (Vector2d& corner : room.outline) corner = to_sheet(corner);
    }
    for (prior::PlanShaft& shaft : plan_.shafts) {
      for (Vector2d& corner : shaft.outline) corner = to_sheet(corner);
    }
    for (prior::PlanWall& wall : plan_.walls) wall.thickness *= std::sqrt(std::abs(linear.determinant()));
    plan_.metres_per_unit.reset();
    Shift();
    result_.graph = std::move(plan_);
    return std::move(result_);
  }

 private:
  const Vector2d& Corner(int index) const { return plan_.corners[static_cast<std::size_t>(index)].point; }

  void LeaveOut() {
    std::vector<prior::PlanWall> kept;
    for (const prior::PlanWall& wall : plan_.walls) {
      if (noise_.Chance(deformation_.left_out)) {
        result_.left_out.push_back({ToCampus(Corner(wall.from)), ToCampus(Corner(wall.to))});
      } else {
        kept.push_back(wall);
      }
    }
    plan_.walls = std::move(kept);
  }

  // Walls that begin at another one, at right angles, and end freely.
  void Invent() {
    result_.invented.assign(plan_.walls.size(), false);
    const std::size_t real = plan_.walls.size();
    const auto wanted = static_cast<int>(std::lround(deformation_.invented * static_cast<double>(real)));
    for (int i = 0; i < wanted && real > 0; ++i) {
      for (int attempt = 0; attempt < kAttempts; ++attempt) {
        const prior::PlanWall from = plan_.walls[static_cast<std::size_t>(noise_.Below(static_cast<int>(real)))];
        const Vector2d way = Corner(from.to) - Corner(from.from);
        const Vector2d begin = Corner(from.from) + noise_.Uniform(0.2, 0.8) * way;
        const double side = noise_.Chance(0.5) ? 1 : -1;
        const Vector2d ahead = side * Vector2d(-way.y(), way.x()).normalized();
        const double length = noise_.Uniform(kShortest, kLongest);
        if (!IsFree(begin, ahead, length)) continue;
        const int first = static_cast<int>(plan_.corners.size());
        plan_.corners.push_back({begin});
        plan_.corners.push_back({begin + length * ahead});
        plan_.walls.push_back({.from = first, .to = first + 1, .thickness = from.thickness});
        result_.invented.push_back(true);
        break;
      }
    }
  }

  bool IsFree(const Vector2d& begin, const Vector2d& ahead, double length) const {
    for (double at = kClearance; at <= length; at += 0.1) {
      for (const prior::PlanWall& wall : plan_.walls) {
        // The wall that it begins at is as far away as it has come.
        if (DistanceToWall(plan_, wall, begin + at * ahead) < std::min(kClearance, 0.9 * at)) return false;
      }
    }
    return true;
  }

  void DropUnused() {
    std::vector<int> number(plan_.corners.size(), -1);
    std::vector<prior::PlanCorner> used;
    for (prior::PlanWall& wall : plan_.walls) {
      for (int* end : {&wall.from, &wall.to}) {
        int& known = number[static_cast<std::size_t>(*end)];
        if (known < 0) {
          known = static_cast<int>(used.size());
          used.push_back(plan_.corners[static_cast<std::size_t>(*end)]);
        }
        *end = known;
      }
    }
    plan_.corners = std::move(used);
  }

  int JambAt(const Vector2d& point) const {
    int nearest = -1;
    double least = kJambReach;
    for (std::size_t i = 0; i < plan_.corners.size(); ++i) {
      const double distance = (plan_.corners[i].point - point).norm();
      if (distance >= least) continue;
      least = distance;
      nearest = static_cast<int>(i);
    }
    return nearest;
  }

  // m, of each corner: its jitter, and that of the door beside it.
  std::vector<Vector2d> Moves() {
    std::vector<double> shortest(plan_.corners.size(), 1e9);
    for (const prior::PlanWall& wall : plan_.walls) {
      const double length = (Corner(wall.to) - Corner(wall.from)).norm();
      for (const int end : {wall.from, wall.to}) {
        shortest[static_cast<std::size_t>(end)] = std::min(shortest[static_cast<std::size_t>(end)], length);
      }
    }
    std::vector<Vector2d> moves;
    for (std::size_t i = 0; i < plan_.corners.size(); ++i) {
      Vector2d move = deformation_.jitter * Vector2d(noise_.Normal(), noise_.Normal());
      const double most = kKeep * shortest[i];
      if (move.norm() > most) move *= most / move.norm();
      moves.push_back(move);
    }
    for (const prior::PlanDoor& door : plan_.doors) {
      const double shift = deformation_.door_shift * noise_.Uniform(-1.0, 1.0);
      const int jambs[] = {JambAt(door.from), JambAt(door.to)};
      if (jambs[0] < 0 || jambs[1] < 0) continue;
      const auto room = [&](int jamb) { return shortest[static_cast<std::size_t>(jamb)] - kKeep; };
      if (std::abs(shift) > std::min(room(jambs[0]), room(jambs[1]))) continue;
      for (const int jamb : jambs) moves[static_cast<std::size_t>(jamb)] += shift * (door.to - door.from).normalized();
    }
    return moves;
  }

  std::array<Stretch, 2> Stretches() {
    std::vector<double> xs;
    std::vector<double> ys;
    for (const prior::PlanCorner& corner : original_.corners) {
      xs.push_back(corner.point.x());
      ys.push_back(corner.point.y());
    }
    Stretch along_x(std::move(xs), deformation_.stretch, noise_);
    Stretch along_y(std::move(ys), deformation_.stretch, noise_);
    return {std::move(along_x), std::move(along_y)};
  }

  Eigen::Matrix2d Linear() {
    const Vector2d scales(noise_.Uniform(deformation_.least_scale, deformation_.most_scale),
                          noise_.Uniform(deformation_.least_scale, deformation_.most_scale));
    result_.mirrored = noise_.Chance(deformation_.mirrored);
    const double turn = deformation_.turned ? noise_.Uniform(0.0, 2 * M_PI) : 0.0;
    const Vector2d axes(result_.mirrored ? -scales.x() : scales.x(), scales.y());
    return deformation_.px_per_m * Eigen::Rotation2Dd(turn).toRotationMatrix() * axes.asDiagonal();
  }

  // Into the picture's pixels.
  void Shift() {
    Vector2d low = Vector2d::Constant(1e9);
    for (const prior::PlanCorner& corner : plan_.corners) low = low.cwiseMin(corner.point);
    const Vector2d shift = Vector2d::Constant(kBorder) - low;
    for (prior::PlanCorner& corner : plan_.corners) corner.point += shift;
    for (prior::PlanDoor& door : plan_.doors) door.from += shift, door.to += shift;
    for (prior::PlanRoom& room : plan_.rooms) {
      for (Vector2d& corner : room.outline) corner += shift;
    }
    for (prior::PlanShaft& shaft : plan_.shafts) {
      for (Vector2d& corner : shaft.outline) corner += shift;
    }
  }

  const PlanDeformation& deformation_;
  Noise noise_;
  prior::PlanGraph plan_;
  const prior::PlanGraph& original_;
  DeformedPlan result_;
};

}  // namespace

DeformedPlan Deform(const prior::PlanGraph& built, const PlanDeformation& deformation) {
  return Deformer(built, deformation).Run();
}

}  // namespace enfilade::simulator
