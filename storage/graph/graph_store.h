// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/environment.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "storage/call_context.h"
#include "storage/graph/link_point_store.h"
#include "storage/maps/map_store.h"

namespace enfilade::storage {

// Why a site's graph has a new version. The numbers are in the database: never reuse one.
enum class GraphCause : std::int16_t {
  kMapAdded = 1,
  kMapChanged = 2,
  kMapRemoved = 3,
  kLinkPointAdded = 4,
  kLinkPointChanged = 5,
  kLinkPointRemoved = 6,
  kOptimized = 7,
  kGeoreferenced = 8,
  kRearranged = 9,
  kPriorMapChanged = 10,
};

struct MapPose {
  MapId map;
  PoseWithCovariance T_world_map;
};

struct GraphMap {
  MapId id;
  std::string display_name;
  int level = 0;
  Environment environment = Environment::kIndoor;
  std::vector<Eigen::Vector2d> outline;           // m, map frame
  std::optional<PoseWithCovariance> T_world_map;  // unset: never joined to the root map
  std::int64_t graph_version = 0;                 // of the site when any of this last changed
};

// The changes of a site's graph since a version, or the whole graph.
struct GraphChanges {
  std::int64_t version = 0;  // 0: the site has no map
  bool complete = false;     // the whole graph: discard any earlier copy
  MapId root;                // carries the world frame; empty if the site has no map
  // First remove, then add or replace.
  std::vector<MapId> removed_maps;
  std::vector<LinkPointId> removed_link_points;
  std::vector<GraphMap> maps;                // by id
  std::vector<StoredLinkPoint> link_points;  // by id
};

struct LinkPointPose {
  LinkPointId link_point;
  PoseWithCovariance T_world_place;
};

// What ties maps together by a prior map in use.
struct StoredPlanTies {
  PriorMapId prior_map;
  std::string sha256;  // of the bytes
  std::string bytes;   // graph::EncodePlanTies; empty: the caller has them
  // Those of its alignment that are still there: no other is tied, not even one that was made again under its id.
  std::vector<MapId> maps = {};
  int level = 0;  // of the prior map
};

// A prior map that contradicts what robots have measured.
struct ContradictedPlan {
  PriorMapId prior_map;
  std::string reason;
};

// The result of an optimisation. Link points that are not listed keep their places.
struct GraphSolution {
  // Whether `maps` lists all maps that the solution poses. Otherwise it lists those whose poses have changed since the
  // last optimisation, and `unposed` those that the solution poses no more.
  bool complete = true;
  std::vector<MapPose> maps = {};
  std::vector<MapId> unposed = {};
  std::vector<LinkPointPose> link_points = {};
  // All link points that the chi-square gate has switched off. Those that were switched off before and are not listed
  // are used again.
  std::vector<LinkPointId> switched_off = {};
  // Those of them that are in use diverge.
  std::vector<ContradictedPlan> contradicted_plans = {};
  double chi2_before = 0.0;
  double chi2_after = 0.0;
  std::int64_t map_count = 0;  // that the solution poses
  std::int64_t residual_count = 0;
};

// The maps whose poses differ between two optimisations, by id.
struct MapPoseChanges {
  std::vector<MapPose> posed;
  std::vector<MapId> unposed;
};

struct GraphVersion {
  std::int64_t version = 0;
  GraphCause cause = GraphCause::kMapAdded;
  std::string resource;  // the changed resource: maps/{map}, linkPoints/{link_point}, rearrangements/{id},
                         // priorMaps/{prior_map}; empty for the whole graph
  std::string actor;     // CallContext::actor of the call that changed it
  TimeNs create_time = 0;
  // Of optimisations only.
  struct Optimization {
    double chi2_before = 0.0;
    double chi2_after = 0.0;
    std::vector<LinkPointId> switched_off;
    std::int64_t map_count = 0;
    std::int64_t residual_count = 0;
  };
  std::optional<Optimization> optimization;
};

// A place in a map with known coordinates on the globe.
struct ControlPoint {
  MapId map;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // m, in the map's frame
  double latitude = 0.0;                               // WGS 84, degrees
  double longitude = 0.0;
};

// Receives new graph versions of all sites as they are committed. Not thread-safe.
class GraphListener {
 public:
  struct Change {
    SiteId site;
    std::int64_t version = 0;
  };

  virtual ~GraphListener() = default;

  // Waits for a change or the context's deadline (no changes, no error). UNAVAILABLE if the connection is lost: open
  // another listener and check every version again.
  virtual absl::StatusOr<std::vector<Change>> Await(const CallContext& context) = 0;
};

// Read access to the graph of a site's maps and link points as a whole. Thread-safe; errors common to all stores: see
// SiteStore.
class GraphReader {
 public:
  static constexpr int kKeptOptimizations = 50;

  virtual ~GraphReader() = default;

  // 0 if the site has no map, or does not exist.
  virtual absl::StatusOr<std::int64_t> GetVersion(const CallContext& context, const SiteId& site) const = 0;
  // A consistent view of one version, also while others write. The whole graph if `since` is 0 or a version that the
  // site has not reached (it was deleted and created again). NOT_FOUND if the site does not exist.
  virtual absl::StatusOr<GraphChanges> ReadChanges(const CallContext& context, const SiteId& site,
                                                   std::int64_t since) const = 0;
  // Versions below `before` (0: all), newest first.
  virtual absl::StatusOr<std::vector<GraphVersion>> ListVersions(const CallContext& context, const SiteId& site,
                                                                 std::int64_t before, int limit) const = 0;
  // The last version after `since` that an optimisation made; 0 if there is none.
  virtual absl::StatusOr<std::int64_t> FindLastOptimization(const CallContext& context, const SiteId& site,
                                                            std::int64_t since) const = 0;
  // What optimisation `version` poses differently than the earlier one `since`; 0: all that it poses. NOT_FOUND unless
  // `version` is one of the last kKeptOptimizations optimisations and poses a map.
  virtual absl::StatusOr<MapPoseChanges> GetMapPoses(const CallContext& context, const SiteId& site,
                                                     std::int64_t version, std::int64_t since) const = 0;
  // The current poses of those of `maps` that have one; of all maps if `maps` is empty.
  virtual absl::StatusOr<std::vector<MapPose>> GetPlaces(const CallContext& context, const SiteId& site,
                                                         const std::vector<MapId>& maps) const = 0;
  virtual absl::StatusOr<std::vector<ControlPoint>> GetControlPoints(const CallContext& context,
                                                                     const SiteId& site) const = 0;
  // Of the prior maps in use, by id; without the bytes of those whose digests are `known`.
  virtual absl::StatusOr<std::vector<StoredPlanTies>> ReadPlanTies(const CallContext& context, const SiteId& site,
                                                                   const std::vector<std::string>& known) const = 0;
};

// The graph of a site's maps and link points as a whole. Thread-safe; errors common to all stores: see SiteStore.
class GraphStore : public GraphReader {
 public:
  // Stores `solution` and returns the new version. ABORTED if the graph is no longer at `version`; NOT_FOUND if the
  // site has no graph.
  virtual absl::StatusOr<std::int64_t> Apply(const CallContext& context, const SiteId& site, std::int64_t version,
                                             const GraphSolution& solution) const = 0;
  // Locks the graph, calls `solve` with the changes since `since` (as ReadChanges returns them), stores its solution
  // and returns the new version. For a graph that is edited too often for Apply to succeed. Writers of the graph wait
  // meanwhile, readers do not; keep `solve` short. If `solve` fails, nothing is stored and its error is returned.
  virtual absl::StatusOr<std::int64_t> SolveHeld(
      const CallContext& context, const SiteId& site, std::int64_t since,
      const std::function<absl::StatusOr<GraphSolution>(const GraphChanges&)>& solve) const = 0;
  // Replaces all control points of the site and returns the new graph version. NOT_FOUND if the site or a map does not
  // exist; INVALID_ARGUMENT if a coordinate is out of range.
  virtual absl::StatusOr<std::int64_t> SetControlPoints(const CallContext& context, const SiteId& site,
                                                        const std::vector<ControlPoint>& points) const = 0;
  // Of those of `sites` that have maps; in any order.
  virtual absl::StatusOr<std::vector<GraphListener::Change>> ListVersionsOf(const CallContext& context,
                                                                            const std::vector<SiteId>& sites) const = 0;
  // Receives every version that is committed after this returns. UNAVAILABLE if the database cannot be reached. The
  // listener holds a connection until it is destroyed, which must be before the store is.
  virtual absl::StatusOr<std::unique_ptr<GraphListener>> Listen(const CallContext& context) const = 0;
};

}  // namespace enfilade::storage
