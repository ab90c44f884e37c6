// SPDX-License-Identifier: Apache-2.0
#include "core/closure/known_places.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/closure/pose_gate.h"
#include "core/graph/search_radius.h"
#include "fmt/format.h"

namespace enfilade::closure {
namespace {

constexpr double kBehindDoor = 0.5;  // m: a robot that is this far through a door still sees it

// How far a place may lie before, behind and beside the robot.
struct Reach {
  double ahead;   // m
  double behind;  // m
  double across;  // m
};

std::optional<KnownPlace> MatchSighting(const graph::LinkPoint& link_point, const graph::Anchor& anchor,
                                        const PoseWithCovariance& T_map_robot, const DoorClosureOptions& options) {
  const bool is_sighting = link_point.is_candidate();
  const Reach reach = is_sighting ? Reach{options.known_along, options.known_along, options.known_across}
                                  : Reach{options.known_ahead, kBehindDoor, options.known_across};
  const Pose2 d = Between(T_map_robot.pose, anchor.T_map_place);
  const double slack = graph::ErrorEllipse95(T_map_robot.covariance + anchor.covariance).semi_major_m;
  if (d.x > reach.ahead + slack || d.x < -reach.behind - slack || std::abs(d.y) > reach.across + slack) {
    return std::nullopt;
  }
  const double facing = options.known_facing * M_PI / 180.0;
  const double opposite = std::abs(WrapAngle(d.yaw + M_PI));
  if (std::abs(d.yaw) > facing && (is_sighting || opposite > facing)) return std::nullopt;
  const double distance = d.translation().norm();
  return KnownPlace{&link_point, 0.0, distance,
                    fmt::format("{} is {:.1f} m ahead and {:.1f} m aside, turned by {:.0f} deg",
                                is_sighting ? "a door seen before" : "a link point", d.x, d.y, d.yaw * 180.0 / M_PI)};
}

template <typename Find>
std::vector<KnownPlace> FindEach(const std::vector<const graph::LinkPoint*>& link_points, const MapId& map,
                                 const Find& find) {
  std::vector<KnownPlace> found;
  for (const graph::LinkPoint* link_point : link_points) {
    const graph::Anchor* anchor = link_point->FindAnchor(map);
    if (anchor == nullptr || link_point->use == graph::LinkPointUse::kSuspended) continue;
    if (std::optional<KnownPlace> place = find(*link_point, *anchor)) found.push_back(*std::move(place));
  }
  std::sort(found.begin(), found.end(), [](const KnownPlace& a, const KnownPlace& b) {
    if (a.chi2 != b.chi2) return a.chi2 < b.chi2;
    return a.distance != b.distance ? a.distance < b.distance : a.link_point->id < b.link_point->id;
  });
  return found;
}

}  // namespace

std::vector<KnownPlace> FindSighted(const std::vector<const graph::LinkPoint*>& link_points, const MapId& map,
                                    const PoseWithCovariance& T_map_robot, const DoorClosureOptions& options) {
  return FindEach(link_points, map, [&](const graph::LinkPoint& link_point, const graph::Anchor& anchor) {
    return MatchSighting(link_point, anchor, T_map_robot, options);
  });
}

std::vector<KnownPlace> FindPassed(const std::vector<const graph::LinkPoint*>& link_points, const MapId& map,
                                   const PoseWithCovariance& T_map_door, const DoorClosureOptions& options) {
  const double gate = Gate(options);
  const PoseWithCovariance before = Compose(T_map_door, {{-options.latch_distance, 0.0, 0.0}, Eigen::Matrix3d::Zero()});
  return FindEach(link_points, map,
                  [&](const graph::LinkPoint& link_point, const graph::Anchor& anchor) -> std::optional<KnownPlace> {
                    if (link_point.is_candidate()) return MatchSighting(link_point, anchor, before, options);
                    const double chi2 = PlaceChiSquared({anchor.T_map_place, anchor.covariance}, T_map_door, options);
                    const double distance = (anchor.T_map_place.translation() - T_map_door.pose.translation()).norm();
                    if (chi2 > gate) return std::nullopt;
                    return KnownPlace{
                        &link_point, chi2, distance,
                        fmt::format("the door lies {:.2f} m from it in the same map (chi-squared {:.1f}, gate {:.1f})",
                                    distance, chi2, gate)};
                  });
}

bool IsDoorOf(const graph::LinkPoint& link_point, const graph::Anchor& anchor, const PoseWithCovariance& T_map_door,
              const DoorClosureOptions& options) {
  if (!link_point.is_candidate()) {
    return PlaceChiSquared({anchor.T_map_place, anchor.covariance}, T_map_door, options) <= Gate(options);
  }
  const Pose2 d = Between(anchor.T_map_place, T_map_door.pose);
  const double slack = graph::ErrorEllipse95(T_map_door.covariance + anchor.covariance).semi_major_m;
  return d.x <= options.known_ahead + slack && d.x >= -kBehindDoor - slack &&
         std::abs(d.y) <= options.known_across + slack &&
         std::abs(WrapAngle(d.yaw + M_PI)) <= options.known_facing * M_PI / 180.0;
}

}  // namespace enfilade::closure
