// SPDX-License-Identifier: Apache-2.0
#include "core/closure/plans/plan_doors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/closure/known_places.h"
#include "core/geometry/segments.h"
#include "core/graph/search_radius.h"
#include "fmt/format.h"

namespace enfilade::closure {
namespace {

constexpr double kDoorYawSigma = 0.05;  // rad: of a door in its wall, as it is drawn and corrected
constexpr double kKnownReach = 1.0;     // m: a link point within it is at the door, whatever it is not sure of

const Pose2 kTurned{0.0, 0.0, M_PI};

// Whether the segments a-b and c-d have a point in common; touching ends count.
bool Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
  return SideOf(a, b, c) * SideOf(a, b, d) <= 0.0 && SideOf(c, d, a) * SideOf(c, d, b) <= 0.0;
}

std::pair<Eigen::Vector2d, Eigen::Vector2d> EndsOf(const PlanDoor& door) {
  return {door.T_plan_door * Eigen::Vector2d(0.0, -0.5 * door.width),
          door.T_plan_door * Eigen::Vector2d(0.0, 0.5 * door.width)};
}

Eigen::Matrix3d CovarianceOf(const PlanDoor& door) {
  const double variance = door.sigma * door.sigma;
  return Eigen::Vector3d(variance, variance, kDoorYawSigma * kDoorYawSigma).asDiagonal();
}

// A candidate before a door.
struct Sighting {
  const graph::LinkPoint* candidate = nullptr;
  MapId map = {};
  int side = 0;
  Pose2 T_door_robot = {};  // as SightedDoor::Side
  double chi2 = 0.0;        // of how far aside of the robot's heading the door is
};

class DoorFinder {
 public:
  DoorFinder(const PlanWithDoors& plan, const graph::GraphSnapshot& graph, const DoorClosureOptions& options)
      : plan_(plan), graph_(graph), options_(options), sightings_(plan.doors.size()), unclear_(plan.doors.size()) {}

  std::vector<SightedDoor> Run() {
    std::vector<SightedDoor> doors(plan_.doors.size());
    for (const graph::MapInPlan& map : plan_.maps) {
      for (const graph::LinkPoint* link_point : graph_.ListLinkPointsIn(map.map)) {
        const graph::Anchor& anchor = *link_point->FindAnchor(map.map);
        if (!link_point->is_candidate()) {
          NoteKnown(*link_point, map.T_plan_map * anchor.T_map_place.translation(), doors);
        } else if (link_point->use != graph::LinkPointUse::kSuspended) {
          Sight(*link_point, anchor, map.T_plan_map);
        }
      }
    }
    for (std::size_t i = 0; i < doors.size(); ++i) Judge(i, doors[i]);
    return doors;
  }

 private:
  // The nearest door has it.
  void NoteKnown(const graph::LinkPoint& link_point, const Eigen::Vector2d& position, std::vector<SightedDoor>& doors) {
    double least = std::numeric_limits<double>::infinity();
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < plan_.doors.size(); ++i) {
      const PlanDoor& door = plan_.doors[i];
      const double distance = (door.T_plan_door.translation() - position).norm();
      if (distance > std::max(kKnownReach, std::sqrt(graph::kChiSquared2Dof95) * door.sigma) || distance >= least) {
        continue;
      }
      least = distance;
      nearest = i;
    }
    if (std::isfinite(least)) doors[nearest].link_point = link_point.id;
  }

  bool IsHidden(const Eigen::Vector2d& from, std::size_t index) const {
    const Eigen::Vector2d to = plan_.doors[index].T_plan_door.translation();
    // Short of the door, so that the walls beside it do not count.
    const Eigen::Vector2d before = from + (to - from) * std::max(0.0, 1.0 - 0.3 / std::max((to - from).norm(), 0.3));
    for (const auto& [a, b] : plan_.walls) {
      if (Cross(from, before, a, b)) return true;
    }
    for (std::size_t i = 0; i < plan_.doors.size(); ++i) {
      const auto [a, b] = EndsOf(plan_.doors[i]);
      if (i != index && Cross(from, before, a, b)) return true;
    }
    return false;
  }

  void Sight(const graph::LinkPoint& candidate, const graph::Anchor& anchor, const Pose2& T_plan_map) {
    const Pose2 T_plan_robot = T_plan_map * anchor.T_map_place;
    std::vector<std::pair<std::size_t, Sighting>> found;
    for (std::size_t i = 0; i < plan_.doors.size(); ++i) {
      const PlanDoor& door = plan_.doors[i];
      const int side = Between(door.T_plan_door, T_plan_robot).x <= 0.0 ? 0 : 1;
      const Pose2 T_plan_through = side == 0 ? door.T_plan_door : door.T_plan_door * kTurned;
      const PoseWithCovariance T_map_into{Between(T_plan_map, T_plan_through * kTurned), CovarianceOf(door)};
      if (!IsDoorOf(candidate, anchor, T_map_into, options_) || IsHidden(T_plan_robot.translation(), i)) continue;
      const Pose2 d = Between(T_plan_robot, T_plan_through);
      const double ahead = options_.place_yaw_sigma * std::max(d.x, 0.0);
      const double variance = options_.place_sigma * options_.place_sigma + door.sigma * door.sigma + ahead * ahead;
      found.push_back({i, {&candidate, anchor.map, side, Between(T_plan_through, T_plan_robot), d.y * d.y / variance}});
    }
    if (found.empty()) return;
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.second.chi2 < b.second.chi2; });
    const bool clear = found.size() == 1 || found[1].second.chi2 - found[0].second.chi2 >= options_.clear_chi2;
    if (clear) return sightings_[found[0].first].push_back(found[0].second);
    for (const auto& [door, sighting] : found) unclear_[door].push_back(sighting.candidate->id);
  }

  std::string Names(const std::set<MapId>& maps) const {
    std::string names;
    for (const MapId& map : maps) {
      const graph::MapInGraph* found = graph_.FindMap(map);
      names += (names.empty() ? "" : ", ") + (found == nullptr ? map.value() : found->display_name);
    }
    return names;
  }

  void Judge(std::size_t index, SightedDoor& door) {
    std::vector<Sighting>& sightings = sightings_[index];
    std::sort(sightings.begin(), sightings.end(), [](const Sighting& a, const Sighting& b) {
      const double x = a.T_door_robot.translation().norm(), y = b.T_door_robot.translation().norm();
      return x != y ? x < y : a.candidate->id < b.candidate->id;
    });
    std::set<MapId> maps[2];
    std::set<LinkPointId> ids(unclear_[index].begin(), unclear_[index].end());
    for (const Sighting& one : sightings) {
      maps[one.side].insert(one.map);
      ids.insert(one.candidate->id);
    }
    door.candidates.assign(ids.begin(), ids.end());
    const auto decide = [&door](SightedDoor::State state, std::string reason) {
      door.state = state;
      door.reason = std::move(reason);
    };
    using State = SightedDoor::State;
    if (door.link_point) return decide(State::kKnown, ids.empty() ? "" : "it has a link point already");
    if (sightings.empty() && ids.empty()) return;
    if (sightings.empty()) return decide(State::kUnclear, "robots may as well have seen another door");
    if (maps[0].empty() || maps[1].empty()) {
      return decide(State::kOneSide,
                    fmt::format("seen from one side only, in {}", Names(maps[maps[0].empty() ? 1 : 0])));
    }
    for (const std::set<MapId>& side : maps) {
      if (side.size() > 1) return decide(State::kUnclear, "seen from one side in several maps: " + Names(side));
    }
    if (maps[0] == maps[1]) return decide(State::kSameMap, fmt::format("{} has both sides", Names(maps[0])));
    const double radius = std::sqrt(graph::kChiSquared2Dof95) * plan_.doors[index].sigma;
    if (radius > options_.sure_radius) {
      return decide(State::kUnclear, fmt::format("the plan has it to {:.1f} m only", radius));
    }
    decide(State::kBothSides, fmt::format("seen from {} and {}", Names(maps[0]), Names(maps[1])));
    for (int side = 0; side < 2; ++side) {
      SightedDoor::Side& out = door.sides[static_cast<std::size_t>(side)];
      for (const Sighting& one : sightings) {
        if (one.side != side) continue;
        if (out.candidates.empty()) out.T_door_robot = one.T_door_robot;
        out.candidates.push_back(one.candidate->id);
      }
      out.map = *maps[side].begin();
    }
  }

  const PlanWithDoors& plan_;
  const graph::GraphSnapshot& graph_;
  const DoorClosureOptions& options_;
  std::vector<std::vector<Sighting>> sightings_;   // by door
  std::vector<std::vector<LinkPointId>> unclear_;  // by door: candidates that may be at another one
};

}  // namespace

std::vector<SightedDoor> FindSightedDoors(const PlanWithDoors& plan, const graph::GraphSnapshot& graph,
                                          const DoorClosureOptions& options) {
  return DoorFinder(plan, graph, options).Run();
}

std::optional<PoseWithCovariance> DoorInMap(const PlanWithDoors& plan, const PlanDoor& door, const MapId& map) {
  for (const graph::MapInPlan& one : plan.maps) {
    if (one.map != map) continue;
    return PoseWithCovariance{Between(one.T_plan_map, door.T_plan_door), CovarianceOf(door)};
  }
  return std::nullopt;
}

}  // namespace enfilade::closure
