// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "core/closure/plans/match_door.h"
#include "core/closure/plans/plan_doors.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/closure/seen_grounds.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/rearrange/rearranger.h"
#include "server/app/runtime/maintenance_loop.h"
#include "storage/graph/plan_join_store.h"
#include "storage/maps/prior_map_store.h"

namespace enfilade::server {

// Makes one link point of two candidates that lie before and behind a door of a plan in use, in two maps, if what
// robots have seen through the door from the one map lies on the walls of the other (core/closure/plans/plan_doors.h,
// match_door.h). Each is a rearrangement of its own, made under the site's lease, with the reason. It is undone when
// the plan is no longer in use, unless a robot has driven through the door meanwhile: then that has measured it.
class PlanDoorJoiner {
 public:
  struct Stores {
    DoorClosureStores doors;
    const storage::PriorMapStore& prior_maps;
    const storage::PlanJoinStore& joins;
  };

  // All must outlive it.
  PlanDoorJoiner(const closure::DoorClosureOptions& options, const Stores& stores, SiteGraphs& graphs,
                 const Rearranger& rearranger);

  // Looks at sites whose graph has changed since they were looked at last, and at those with doors that could not be
  // decided then. Returns how many link points it has made and taken back. Not thread-safe.
  absl::StatusOr<std::int64_t> Run(const storage::CallContext& context);

  // As a job of a MaintenanceLoop, which this must outlive.
  MaintenanceJob Job();

 private:
  using Clock = std::chrono::steady_clock;

  // A door of a plan that two maps have seen from both sides, and how.
  struct Door {
    PriorMapId plan;
    int number = 0;
    closure::PlanDoor door;
    closure::SightedDoor sighted;
    closure::DoorInMaps in_maps;  // `here`: side 0
  };
  // What the scans say of it.
  struct Confirmation {
    closure::DoorMatch match;
    Eigen::Matrix3d covariance_here = Eigen::Matrix3d::Zero();  // of T_here_door
    bool is_early = false;                                      // robots are still recording, or their maps are made
  };
  struct LookedAt {
    std::int64_t graph_version = 0;
    Clock::time_point again = Clock::time_point::max();
    int times = 0;
  };

  absl::StatusOr<std::int64_t> Look(const SiteId& site, LookedAt& last);
  absl::StatusOr<std::int64_t> Withdraw(const SiteId& site, const SiteGraph& graph,
                                        const std::vector<storage::PlanJoin>& joins) const;
  absl::Status TakeBack(const storage::SiteLease& lease, const storage::PlanJoin& join) const;
  absl::StatusOr<std::vector<Door>> FindDoors(const SiteId& site, const SiteGraph& graph,
                                              const std::vector<storage::PlanJoin>& joins) const;
  absl::StatusOr<Confirmation> Confirm(const SiteId& site, const SiteGraph& graph, const Door& door);
  // ABORTED if the graph has changed meanwhile; ALREADY_EXISTS if the database has a link point there.
  absl::Status Join(const SiteId& site, const SiteGraph& graph, const Door& door, const Confirmation& confirmed) const;

  const closure::DoorClosureOptions options_;
  const Stores stores_;
  SiteGraphs& graphs_;
  const Rearranger& rearranger_;
  const std::string owner_;
  SeenGrounds grounds_{0};
  std::map<SiteId, LookedAt> looked_at_;
};

}  // namespace enfilade::server
