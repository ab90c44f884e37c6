// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/shafts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include "core/graph/chi_squared.h"
#include "fmt/format.h"

namespace enfilade::graph {
namespace {

using Eigen::Vector2d;
using Points = std::vector<Vector2d>;

constexpr double kProbability = 0.99;
constexpr double kMostTurn = 45.0 * kDegree;  // half of the turn after which a shaft looks the same

Vector2d MeanOf(const Points& points) {
  Vector2d sum = Vector2d::Zero();
  for (const Vector2d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

double SquaredDistance(const Points& a, const Points& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return sum;
}

Points Moved(const Pose2& T_to_from, Points points) {
  for (Vector2d& point : points) point = T_to_from * point;
  return points;
}

// How far one point of a plan, which is `distance` away from what it is compared by, may be off in each axis: m^2.
double DrawingVariance(const PlanTies& ties, double distance) {
  const double stretch = ties.stretch_sigma * distance;
  return ties.corner_sigma * ties.corner_sigma + stretch * stretch;
}

// Index of each name that one shaft has.
std::map<std::string, std::size_t> Named(const PlanTies& ties) {
  std::map<std::string, std::size_t> named;
  std::map<std::string, int> count;
  for (std::size_t i = 0; i < ties.shafts.size(); ++i) {
    named[ties.shafts[i].name] = i;
    ++count[ties.shafts[i].name];
  }
  std::erase_if(named, [&](const auto& one) { return one.first.empty() || count[one.first] > 1; });
  return named;
}

bool HaveOneShape(const PlanTies& ties_a, const ShaftInPlan& a, const PlanTies& ties_b, const ShaftInPlan& b) {
  const std::size_t corners = a.outline.size();
  if (corners != b.outline.size() || corners < 3) return false;
  double least = std::numeric_limits<double>::infinity();
  Points outline = b.outline;
  for (std::size_t i = 0; i < corners; ++i) {
    least = std::min(least, SquaredDistance(a.outline, Moved(FitRigid(a.outline, outline), outline)));
    std::rotate(outline.begin(), outline.begin() + 1, outline.end());
  }
  double radius = 0.0;
  for (const Vector2d& corner : a.outline) radius = std::max(radius, (corner - a.middle()).norm());
  const double variance = kShaftSigma * kShaftSigma + DrawingVariance(ties_a, radius) + DrawingVariance(ties_b, radius);
  return least / variance <= ChiSquaredQuantile(kProbability, static_cast<int>(2 * corners) - 3);
}

// A shaft of a plan, and the same one of a placed plan.
struct KnownShaft {
  const ShaftInPlan* shaft = nullptr;
  Points in_world = {};
  const PlanTies* known_by = nullptr;
  int levels = 0;  // between the two plans
};

// By name.
std::map<std::string, KnownShaft> KnownShafts(const PlanTies& ties, int level, const std::vector<PlacedPlan>& placed) {
  std::map<std::string, KnownShaft> known;
  for (const PlacedPlan& other : placed) {
    const int levels = std::abs(other.plan->level - level);
    if (levels == 0) continue;
    const PlanTies& there = *other.plan->ties;
    for (const SameShaft& same : SameShafts(ties, there)) {
      const ShaftInPlan& shaft = ties.shafts[same.a];
      KnownShaft& one = known[shaft.name];
      if (one.shaft != nullptr && one.levels <= levels) continue;
      one = {&shaft, Moved(other.T_world_plan, there.shafts[same.b].outline), &there, levels};
    }
  }
  return known;
}

}  // namespace

std::vector<SameShaft> SameShafts(const PlanTies& a, const PlanTies& b) {
  const std::map<std::string, std::size_t> named_a = Named(a);
  const std::map<std::string, std::size_t> named_b = Named(b);
  std::vector<SameShaft> same;
  for (std::size_t i = 0; i < a.shafts.size(); ++i) {
    const ShaftInPlan& shaft = a.shafts[i];
    const auto there = named_b.find(shaft.name);
    if (!named_a.contains(shaft.name) || there == named_b.end()) continue;
    const ShaftInPlan& other = b.shafts[there->second];
    if (shaft.is_lift == other.is_lift && HaveOneShape(a, shaft, b, other)) same.push_back({i, there->second});
  }
  return same;
}

Pose2 FitRigid(const Points& to, const Points& from) {
  const Vector2d mean_to = MeanOf(to);
  const Vector2d mean_from = MeanOf(from);
  double cosine = 0.0;
  double sine = 0.0;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const Vector2d a = from[i] - mean_from;
    const Vector2d b = to[i] - mean_to;
    cosine += a.dot(b);
    sine += a.x() * b.y() - a.y() * b.x();
  }
  const double yaw = std::atan2(sine, cosine);
  const Vector2d shift = mean_to - Eigen::Rotation2Dd(yaw) * mean_from;
  return {shift.x(), shift.y(), yaw};
}

Points InOrderOf(const Points& a, Points b) {
  Points best = b;
  for (std::size_t i = 1; i < b.size(); ++i) {
    std::rotate(b.begin(), b.begin() + 1, b.end());
    if (SquaredDistance(a, b) < SquaredDistance(a, best)) best = b;
  }
  return best;
}

ShaftPlacement PlaceByShafts(const PlanTies& ties, int level, const std::vector<PlacedPlan>& placed) {
  ShaftPlacement placement;
  const std::map<std::string, KnownShaft> known = KnownShafts(ties, level, placed);
  for (const auto& [name, one] : known) placement.shafts.push_back(name);
  if (known.size() < 2) {
    placement.reason = known.empty() ? "it shares no shaft with a plan in use of another level"
                                     : fmt::format(
                                           "it shares only the shaft \"{}\" with plans in use of other levels, "
                                           "and two are needed",
                                           known.begin()->first);
    return placement;
  }
  Points in_plan, in_world;
  for (const auto& [name, one] : known) {
    in_plan.push_back(one.shaft->middle());
    in_world.push_back(MeanOf(one.in_world));
  }
  const Vector2d mean = MeanOf(in_plan);
  Pose2 T_world_plan = FitRigid(in_world, in_plan);
  double chi2 = 0.0;
  double turn_information = 0.0;  // rad^-2
  std::size_t i = 0;
  for (const auto& [name, one] : known) {
    const double radius = (in_plan[i] - mean).norm();
    const double variance =
        kShaftSigma * kShaftSigma + DrawingVariance(ties, radius) + DrawingVariance(*one.known_by, radius);
    chi2 += (T_world_plan * in_plan[i] - in_world[i]).squaredNorm() / variance;
    turn_information += radius * radius / variance;
    ++i;
  }
  if (chi2 > ChiSquaredQuantile(kProbability, static_cast<int>(2 * known.size()) - 3)) {
    placement.reason = fmt::format("its shafts {} lie otherwise to each other than on other levels: chi-squared {:.1f}",
                                   fmt::join(placement.shafts, ", "), chi2);
    return placement;
  }
  if (3.0 > kMostTurn * std::sqrt(turn_information)) {
    placement.reason =
        fmt::format("its shafts {} lie too near to each other to tell its turn", fmt::join(placement.shafts, ", "));
    return placement;
  }
  // The turn tells the corners of a shaft apart, and they say whether it is right.
  Points corners, corners_in_world;
  double chi2_of_turns = 0.0;
  int degrees_of_freedom = 0;
  for (const auto& [name, one] : known) {
    const Points here = Moved(T_world_plan, one.shaft->outline);
    const Points there = InOrderOf(here, one.in_world);
    corners.insert(corners.end(), one.shaft->outline.begin(), one.shaft->outline.end());
    corners_in_world.insert(corners_in_world.end(), there.begin(), there.end());
    const Vector2d off = MeanOf(here) - MeanOf(there);
    for (std::size_t k = 0; k < here.size(); ++k) {
      const double radius = (there[k] - MeanOf(there)).norm();
      const double variance =
          kShaftSigma * kShaftSigma + DrawingVariance(ties, radius) + DrawingVariance(*one.known_by, radius);
      chi2_of_turns += (here[k] - there[k] - off).squaredNorm() / variance;
    }
    degrees_of_freedom += static_cast<int>(2 * here.size()) - 2;
  }
  if (chi2_of_turns > ChiSquaredQuantile(kProbability, degrees_of_freedom)) {
    placement.reason = fmt::format("its shafts {} are turned otherwise than on other levels: chi-squared {:.1f}",
                                   fmt::join(placement.shafts, ", "), chi2_of_turns);
    return placement;
  }
  placement.T_world_plan = FitRigid(corners_in_world, corners);
  return placement;
}

}  // namespace enfilade::graph
