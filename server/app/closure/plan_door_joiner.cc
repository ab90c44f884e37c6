// SPDX-License-Identifier: Apache-2.0
#include "server/app/closure/plan_door_joiner.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "core/closure/pose_gate.h"
#include "core/rearrange/rearrangement.h"
#include "fmt/format.h"
#include "server/app/closure/judging_lease.h"
#include "server/app/closure/known_scans.h"
#include "server/app/graph/held_site_lease.h"
#include "server/app/priors/plan_doors.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

constexpr auto kLeaseTime = std::chrono::seconds(30);
constexpr auto kLeaseWait = std::chrono::seconds(10);
// A door that is not decided is looked at again after this, then after twice as long, and so on.
constexpr auto kFirstWait = std::chrono::seconds(5);
constexpr int kMostDoublings = 7;
constexpr auto kAfterError = std::chrono::seconds(60);
constexpr double kSightReach = 8.0;  // m from a door: robots farther away see little through it

storage::CallContext Changing() { return storage::CallContext::WithTimeout(kLeaseWait); }

std::set<LinkPointId> CandidatesOf(const closure::SightedDoor& door) {
  std::set<LinkPointId> ids;
  for (const auto& side : door.sides) ids.insert(side.candidates.begin(), side.candidates.end());
  return ids;
}

// A person has taken back what would be made again of these candidates.
bool IsRefused(const closure::SightedDoor& door, const std::vector<storage::PlanJoin>& joins) {
  const std::set<LinkPointId> now = CandidatesOf(door);
  return std::any_of(joins.begin(), joins.end(), [&](const storage::PlanJoin& join) {
    return join.undone && now.contains(join.link_point) &&
           std::any_of(join.candidates.begin(), join.candidates.end(),
                       [&](const LinkPointId& id) { return now.contains(id); });
  });
}

// The scan's pose nearest to the door.
Eigen::Matrix3d CovarianceAt(const std::vector<closure::PlacedScan>& scans, const Pose2& T_map_door) {
  const auto distance = [&](const closure::PlacedScan& one) {
    return Between(T_map_door, one.T_map_robot.pose).translation().norm();
  };
  return std::min_element(scans.begin(), scans.end(),
                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); })
      ->T_map_robot.covariance;
}

closure::SeenGround GroundOf(const graph::GraphSnapshot& graph, const MapId& map,
                             const std::vector<closure::PlacedScan>& scans, const Pose2& T_map_door) {
  std::vector<Pose2> doors = DoorsOf(graph, map);
  doors.push_back(T_map_door);
  return closure::SeenGround(closure::RemoveHitsThroughDoors(scans, doors));
}

const Pose2 kOtherWay{0.0, 0.0, M_PI};

}  // namespace

PlanDoorJoiner::PlanDoorJoiner(const closure::DoorClosureOptions& options, const Stores& stores, SiteGraphs& graphs,
                               const Rearranger& rearranger)
    : options_(options), stores_(stores), graphs_(graphs), rearranger_(rearranger), owner_(NewUuid() + "/plans") {}

MaintenanceJob PlanDoorJoiner::Job() {
  return {"doors of plans", [this](const storage::CallContext& context, std::int64_t) { return Run(context); },
          "joined or taken back"};
}

absl::StatusOr<std::int64_t> PlanDoorJoiner::Run(const storage::CallContext& context) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<storage::SiteWithPlans> sites, stores_.joins.ListSites(context));
  std::erase_if(looked_at_, [&](const auto& one) {
    return std::none_of(sites.begin(), sites.end(), [&](const auto& site) { return site.site == one.first; });
  });
  std::int64_t changed = 0;
  for (const storage::SiteWithPlans& site : sites) {
    LookedAt& last = looked_at_[site.site];
    if (last.graph_version == site.graph_version && Clock::now() < last.again) continue;
    const absl::StatusOr<std::int64_t> done = Look(site.site, last);
    changed += done.value_or(0);
    // What was seen has changed meanwhile, or is being changed: that is usual.
    if (done.ok() || absl::IsAborted(done.status()) || absl::IsNotFound(done.status())) continue;
    last = {site.graph_version, Clock::now() + kAfterError};
    spdlog::warn("the doors of the plans of {}: {}; will retry", NameOf(site.site), done.status().ToString());
  }
  return changed;
}

absl::StatusOr<std::int64_t> PlanDoorJoiner::Look(const SiteId& site, LookedAt& last) {
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, graphs_.Get(JudgingLease::Context(), site));
  ENFILADE_ASSIGN_OR_RETURN(const auto joins, stores_.joins.List(JudgingLease::Context(), site));
  ENFILADE_ASSIGN_OR_RETURN(std::int64_t changed, Withdraw(site, *graph, joins));
  if (changed > 0) return changed;  // the graph is another one
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Door> doors, FindDoors(site, *graph, joins));
  bool is_open = false;
  for (const Door& door : doors) {
    ENFILADE_ASSIGN_OR_RETURN(const Confirmation confirmed, Confirm(site, *graph, door));
    if (confirmed.is_early || !confirmed.match.T_there_door) {
      spdlog::debug("door {} of {}: {}: {}", door.number, NameOf(site, door.plan), door.sighted.reason,
                    confirmed.match.reason);
      is_open = true;
      continue;
    }
    const absl::Status joined = Join(site, *graph, door, confirmed);
    if (joined.ok()) return 1;  // the others by the graph as it is then
    if (!absl::IsAlreadyExists(joined)) return joined;
    spdlog::debug("door {} of {}: {}", door.number, NameOf(site, door.plan), joined.ToString());
    is_open = true;
  }
  if (last.graph_version != graph->graph().version()) last.times = 0;
  last.graph_version = graph->graph().version();
  last.again =
      is_open ? Clock::now() + kFirstWait * (1 << std::min(last.times++, kMostDoublings)) : Clock::time_point::max();
  return 0;
}

absl::StatusOr<std::int64_t> PlanDoorJoiner::Withdraw(const SiteId& site, const SiteGraph& graph,
                                                      const std::vector<storage::PlanJoin>& joins) const {
  const std::vector<graph::PlanInGraph>& plans = graph.graph().plans();
  std::vector<const storage::PlanJoin*> due;
  for (const storage::PlanJoin& join : joins) {
    const bool is_in_use =
        std::any_of(plans.begin(), plans.end(), [&](const auto& one) { return one.id == join.plan; });
    const graph::LinkPoint* link_point = graph.graph().FindLinkPoint(join.link_point);
    if (join.undone || join.passed || is_in_use || link_point == nullptr || link_point->pinned) continue;
    if (link_point->use != graph::LinkPointUse::kSuspended) due.push_back(&join);
  }
  if (due.empty()) return 0;
  ENFILADE_ASSIGN_OR_RETURN(const HeldSiteLease lease,
                            HeldSiteLease::Await(stores_.doors.leases, Changing(), site, owner_, kLeaseTime, nullptr));
  for (const storage::PlanJoin* join : due) ENFILADE_RETURN_IF_ERROR(TakeBack(*lease, *join));
  return static_cast<std::int64_t>(due.size());
}

absl::Status PlanDoorJoiner::TakeBack(const storage::SiteLease& lease, const storage::PlanJoin& join) const {
  const absl::Status undone = rearranger_.Undo(Changing(), lease, join.rearrangement).status();
  if (undone.ok()) return stores_.joins.MarkWithdrawn(Changing(), lease.site, join.rearrangement);
  if (!absl::IsFailedPrecondition(undone)) return undone;
  // Something else has changed it since, such as a survey that has moved its map's sessions.
  spdlog::info("{} is suspended, because {} is no longer in use: {}", NameOf(lease.site, join.link_point),
               NameOf(lease.site, join.plan), undone.ToString());
  const auto suspended =
      stores_.doors.link_points.SetSuspended(Changing(), lease.site, join.link_point, /*etag=*/0, /*suspended=*/true);
  graphs_.MarkChanged(lease.site);
  return suspended.status();
}

absl::StatusOr<std::vector<PlanDoorJoiner::Door>> PlanDoorJoiner::FindDoors(
    const SiteId& site, const SiteGraph& graph, const std::vector<storage::PlanJoin>& joins) const {
  std::vector<Door> doors;
  for (const graph::PlanInGraph& in_use : graph.graph().plans()) {
    if (in_use.ties == nullptr) continue;
    ENFILADE_ASSIGN_OR_RETURN(
        const closure::PlanWithDoors plan,
        ReadPlanDoors(JudgingLease::Context(), stores_.prior_maps, stores_.doors.blobs, site, in_use.id, *in_use.ties));
    const std::vector<closure::SightedDoor> sighted = closure::FindSightedDoors(plan, graph.graph(), options_);
    for (std::size_t i = 0; i < sighted.size(); ++i) {
      if (sighted[i].state != closure::SightedDoor::State::kBothSides || IsRefused(sighted[i], joins)) continue;
      const auto here = closure::DoorInMap(plan, plan.doors[i], sighted[i].sides[0].map);
      const auto there = closure::DoorInMap(plan, plan.doors[i], sighted[i].sides[1].map);
      doors.push_back({in_use.id, static_cast<int>(i), plan.doors[i], sighted[i], {here->pose, there->pose}});
    }
  }
  return doors;
}

absl::StatusOr<PlanDoorJoiner::Confirmation> PlanDoorJoiner::Confirm(const SiteId& site, const SiteGraph& graph,
                                                                     const Door& door) {
  Confirmation confirmation;
  const MapId& here = door.sighted.sides[0].map;
  const MapId& there = door.sighted.sides[1].map;
  ENFILADE_ASSIGN_OR_RETURN(const auto predicted, closure::PredictBetween(graph.graph(), there, here));
  if (!predicted) {
    confirmation.match.reason = "the plan does not say well enough where the two maps are";
    return confirmation;
  }
  const PoseWithCovariance door_here{door.in_maps.T_here_door, Eigen::Matrix3d::Zero()};
  const PoseWithCovariance T_there_door = Compose(*predicted, door_here);
  const double variance = door.door.sigma * door.door.sigma;
  const PoseWithCovariance drawn{door.in_maps.T_there_door, Eigen::Vector3d(variance, variance, 0.0).asDiagonal()};
  const double chi2 = closure::PoseChiSquared(T_there_door, drawn, options_.place_sigma, options_.place_yaw_sigma);
  if (chi2 > closure::Gate(options_)) {
    confirmation.match.reason =
        fmt::format("the graph has the two maps elsewhere than the plan has the door, chi-squared {:.1f}", chi2);
    return confirmation;
  }
  const KnownScansScope scope{stores_.doors, site, graph.graph(), options_, grounds_};
  const auto read = [&](const MapId& map, const Pose2& T_map_door, double reach) {
    return ReadScansAround(scope, map, T_map_door, reach);
  };
  ENFILADE_ASSIGN_OR_RETURN(const ScansAround near_here, read(here, door.in_maps.T_here_door, kSightReach));
  ENFILADE_ASSIGN_OR_RETURN(const ScansAround near_there, read(there, door.in_maps.T_there_door, kSightReach));
  confirmation.is_early = near_here.recording || near_here.mapping || near_there.recording || near_there.mapping;
  if (confirmation.is_early || near_here.scans.empty() || near_there.scans.empty()) {
    confirmation.match.reason = confirmation.is_early ? "robots are still there" : "no scans are kept";
    return confirmation;
  }
  ENFILADE_ASSIGN_OR_RETURN(const ScansAround all_here, read(here, door.in_maps.T_here_door, options_.locate_reach));
  ENFILADE_ASSIGN_OR_RETURN(const ScansAround all_there, read(there, door.in_maps.T_there_door, options_.locate_reach));
  const closure::SeenGround ground_here = GroundOf(graph.graph(), here, all_here.scans, door.in_maps.T_here_door);
  const closure::SeenGround ground_there = GroundOf(graph.graph(), there, all_there.scans, door.in_maps.T_there_door);
  const closure::ScanLocation forth = closure::LocateByScans(
      &ground_there, closure::PointsThroughDoor(near_here.scans, door.in_maps.T_here_door, door.door.width),
      T_there_door, options_);
  // x of the door must point out of the map that it is seen from.
  std::vector<Eigen::Vector2d> seen_back =
      closure::PointsThroughDoor(near_there.scans, door.in_maps.T_there_door * kOtherWay, door.door.width);
  for (Eigen::Vector2d& point : seen_back) point = kOtherWay * point;
  const PoseWithCovariance T_here_theirs =
      Compose(Inverse(*predicted), {door.in_maps.T_there_door, Eigen::Matrix3d::Zero()});
  const closure::ScanLocation back = closure::LocateByScans(&ground_here, seen_back, T_here_theirs, options_);
  confirmation.match = closure::JudgeDoorScans(forth, back, door.in_maps, options_);
  confirmation.covariance_here = CovarianceAt(near_here.scans, door.in_maps.T_here_door);
  return confirmation;
}

absl::Status PlanDoorJoiner::Join(const SiteId& site, const SiteGraph& graph, const Door& door,
                                  const Confirmation& confirmed) const {
  const auto& sides = door.sighted.sides;
  const graph::LinkPoint* candidate = graph.graph().FindLinkPoint(sides[0].candidates.front());
  rearrange::Rearrangement joined;
  joined.plan = door.plan;
  joined.reason = fmt::format("door {} of {}: {}; {}", door.number, NameOf(site, door.plan), door.sighted.reason,
                              confirmed.match.reason);
  graph::LinkPoint link_point = *candidate;
  const double variance = options_.origin_sigma * options_.origin_sigma;
  const double yaw_variance = options_.origin_yaw_sigma * options_.origin_yaw_sigma;
  const Eigen::Matrix3d least = Eigen::Vector3d(variance, variance, yaw_variance).asDiagonal();
  link_point.anchors = {
      {sides[0].map, door.in_maps.T_here_door, confirmed.covariance_here + least},
      {sides[1].map, confirmed.match.T_there_door->pose, confirmed.match.T_there_door->covariance + least}};
  link_point.direction = sides[1].map;
  joined.link_points.push_back(std::move(link_point));
  for (const LinkPointId& id : CandidatesOf(door.sighted)) {
    if (id != candidate->id) joined.removed_link_points.push_back(id);
  }
  ENFILADE_ASSIGN_OR_RETURN(const HeldSiteLease lease,
                            HeldSiteLease::Await(stores_.doors.leases, Changing(), site, owner_, kLeaseTime, nullptr));
  return rearranger_.Apply(Changing(), *lease, joined, graph.graph().version()).status();
}

}  // namespace enfilade::server
