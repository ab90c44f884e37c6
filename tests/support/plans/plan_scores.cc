// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plans/plan_scores.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/prior/plan/segment_grid.h"

namespace enfilade::testing {
namespace {

using Eigen::Vector2d;

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

// How samples on walls of one plan lie to the walls of another.
struct SampledWalls {
  std::vector<double> distances;  // of those on a wall
  std::vector<Vector2d> off;

  double ShareOn() const {
    const double all = static_cast<double>(distances.size() + off.size());
    return all > 0 ? static_cast<double>(distances.size()) / all : 0;
  }
};

SampledWalls SampleWalls(const prior::PlanGraph& of, const prior::PlanGraph& on, const PlanTolerance& tolerance) {
  const auto reach = [&](const prior::PlanWall& wall) {
    return tolerance.within_thickness ? std::max(tolerance.distance, wall.thickness / 2) : tolerance.distance;
  };
  double farthest = 1e-6;
  for (const prior::PlanWall& wall : of.walls) farthest = std::max(farthest, reach(wall));
  for (const prior::PlanWall& wall : on.walls) farthest = std::max(farthest, reach(wall));
  prior::SegmentGrid grid(farthest);
  for (std::size_t i = 0; i < on.walls.size(); ++i) {
    grid.Add(static_cast<int>(i), on.corners[on.walls[i].from].point, on.corners[on.walls[i].to].point);
  }
  SampledWalls sampled;
  for (const prior::PlanWall& wall : of.walls) {
    const Vector2d a = of.corners[wall.from].point, b = of.corners[wall.to].point;
    const Vector2d direction = (b - a).normalized();
    const int samples = std::max(1, static_cast<int>((b - a).norm() / tolerance.step));
    for (int k = 0; k < samples; ++k) {
      const Vector2d p = a + (b - a) * ((k + 0.5) / samples);
      double nearest = farthest * 1.0000001;
      bool found = false;
      grid.ForEachNear(p, p, [&](int id) {
        const Vector2d c = on.corners[on.walls[id].from].point, d = on.corners[on.walls[id].to].point;
        const double cosine = std::abs(direction.dot((d - c).normalized()));
        if (cosine < std::cos(tolerance.angle)) return;
        const double share = std::clamp((p - c).dot(d - c) / (d - c).squaredNorm(), 0.0, 1.0);
        const double distance = (c + share * (d - c) - p).norm();
        if (distance > nearest || distance > 1.0000001 * std::max(reach(wall), reach(on.walls[id]))) return;
        nearest = distance;
        found = true;
      });
      if (found) {
        sampled.distances.push_back(nearest);
      } else {
        sampled.off.push_back(p);
      }
    }
  }
  return sampled;
}

// Ends, and where walls of different directions meet; near ones are one.
std::vector<Vector2d> TrueCorners(const prior::PlanGraph& plan, double same) {
  std::vector<std::pair<Vector2d, Vector2d>> rays;  // from, direction
  for (const prior::PlanWall& wall : plan.walls) {
    const Vector2d a = plan.corners[wall.from].point, b = plan.corners[wall.to].point;
    rays.emplace_back(a, (b - a).normalized());
    rays.emplace_back(b, (a - b).normalized());
  }
  std::vector<Vector2d> corners;
  for (const auto& [p, direction] : rays) {
    if (std::any_of(corners.begin(), corners.end(), [&](const Vector2d& c) { return (c - p).norm() < same; })) continue;
    int around = 0;
    bool straight = false;
    for (const auto& [q, other] : rays) {
      if ((q - p).norm() >= same) continue;
      ++around;
      straight = straight || direction.dot(other) < -std::cos(10 * M_PI / 180);
    }
    if (around == 2 && straight) continue;  // one line in two pieces
    corners.push_back(p);
  }
  return corners;
}

PlanScore MatchPoints(const std::vector<Vector2d>& found, const std::vector<Vector2d>& expected, double reach) {
  const auto nearest = [&](const Vector2d& p, const std::vector<Vector2d>& points) {
    double least = 1e300;
    for (const Vector2d& q : points) least = std::min(least, (q - p).norm());
    return least;
  };
  PlanScore score;
  std::vector<double> errors;
  for (const Vector2d& p : expected) {
    const double error = nearest(p, found);
    if (error <= reach) errors.push_back(error);
  }
  score.recall = expected.empty() ? 0 : static_cast<double>(errors.size()) / static_cast<double>(expected.size());
  const auto is_true = [&](const Vector2d& p) { return nearest(p, expected) <= reach; };
  score.precision = found.empty() ? 0
                                  : static_cast<double>(std::count_if(found.begin(), found.end(), is_true)) /
                                        static_cast<double>(found.size());
  score.median_error = Median(errors);
  return score;
}

std::vector<Vector2d> MiddlesOfDoors(const prior::PlanGraph& plan) {
  std::vector<Vector2d> middles;
  for (const prior::PlanDoor& door : plan.doors) middles.push_back((door.from + door.to) / 2);
  return middles;
}

}  // namespace

PlanScore ScoreWalls(const prior::PlanGraph& found, const prior::PlanGraph& expected, const PlanTolerance& tolerance) {
  const SampledWalls on_found = SampleWalls(expected, found, tolerance);
  return {.recall = on_found.ShareOn(),
          .precision = SampleWalls(found, expected, tolerance).ShareOn(),
          .median_error = Median(on_found.distances)};
}

std::vector<Vector2d> SamplesOffWalls(const prior::PlanGraph& of, const prior::PlanGraph& on,
                                      const PlanTolerance& tolerance) {
  return SampleWalls(of, on, tolerance).off;
}

double ShareOfDoubleWalls(const prior::PlanGraph& plan, double step, double reach) {
  prior::SegmentGrid grid(std::max(reach, 1e-6));
  const auto from = [&](int wall) { return plan.corners[plan.walls[wall].from].point; };
  const auto to = [&](int wall) { return plan.corners[plan.walls[wall].to].point; };
  for (int i = 0; i < static_cast<int>(plan.walls.size()); ++i) grid.Add(i, from(i), to(i));
  int all = 0, doubled = 0;
  for (int i = 0; i < static_cast<int>(plan.walls.size()); ++i) {
    const Vector2d direction = (to(i) - from(i)).normalized();
    const int samples = std::max(1, static_cast<int>((to(i) - from(i)).norm() / step));
    for (int k = 0; k < samples; ++k) {
      const Vector2d p = from(i) + (to(i) - from(i)) * ((k + 0.5) / samples);
      bool beside = false;
      grid.ForEachNear(p, p, [&](int other) {
        const Vector2d along = to(other) - from(other);
        if (other == i || std::abs(direction.dot(along.normalized())) < std::cos(PlanTolerance().angle)) return;
        const double share = (p - from(other)).dot(along) / along.squaredNorm();
        const Vector2d foot = from(other) + share * along;
        beside = beside || (share >= 0 && share <= 1 && (foot - p).norm() <= reach);
      });
      ++all;
      doubled += beside ? 1 : 0;
    }
  }
  return all > 0 ? static_cast<double>(doubled) / all : 0;
}

PlanScore ScoreCorners(const prior::PlanGraph& found, const prior::PlanGraph& expected,
                       const PlanTolerance& tolerance) {
  const double same = tolerance.corner_distance / 3;
  return MatchPoints(TrueCorners(found, same), TrueCorners(expected, same), tolerance.corner_distance);
}

PlanScore ScoreDoors(const prior::PlanGraph& found, const prior::PlanGraph& expected, const PlanTolerance& tolerance) {
  return MatchPoints(MiddlesOfDoors(found), MiddlesOfDoors(expected), tolerance.door_distance);
}

PlanTolerance InUnits(const PlanTolerance& tolerance, double metres_per_unit) {
  PlanTolerance units = tolerance;
  for (double* length : {&units.step, &units.distance, &units.corner_distance, &units.door_distance})
    *length /= metres_per_unit;
  return units;
}

}  // namespace enfilade::testing
