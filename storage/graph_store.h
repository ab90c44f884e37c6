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
#include "storage/link_point_store.h"
#include "storage/map_store.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

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

// What became of a site's graph since a version, or all of it.
struct GraphChanges {
  std::int64_t version = 0;  // 0: the site has no map
  bool complete = false;     // all of the graph: forget what you had
  MapId root;                // carries the world frame; empty where there is no map
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

// What an optimisation found. Whatever is not named keeps its place.
struct GraphSolution {
  std::vector<MapPose> maps;
  std::vector<LinkPointPose> link_points;
  // All that the chi-square gate has switched off; those switched off before and not named here are used again.
  std::vector<LinkPointId> switched_off;
  double chi2_before = 0.0;
  double chi2_after = 0.0;
  std::int64_t residual_count = 0;
};

struct GraphVersion {
  std::int64_t version = 0;
  GraphCause cause = GraphCause::kMapAdded;
  std::string resource;  // what was changed: maps/{map}, linkPoints/{link_point}; empty for the whole
  std::string actor;     // who, as the caller said
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

// A place whose coordinates are known on the globe, too.
struct ControlPoint {
  MapId map;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // m, in the map's frame
  double latitude = 0.0;                               // WGS 84, degrees
  double longitude = 0.0;
};

// The graph of a site's maps and link points as a whole. Thread-safe; errors common to all stores: see SiteStore.
class GraphStore {
 public:
  explicit GraphStore(postgres::Pool& pool) : pool_(pool) {}

  // 0 where the site has no map, or does not exist.
  absl::StatusOr<std::int64_t> GetVersion(const CallContext& context, const SiteId& site) const;
  // All of one version, however many write meanwhile. `since` 0, or a version that the site does not have yet (it was
  // deleted and made again): the whole graph. NOT_FOUND where the site does not exist.
  absl::StatusOr<GraphChanges> ReadChanges(const CallContext& context, const SiteId& site, std::int64_t since) const;
  // Stores `solution` as a new version, which is returned. ABORTED where the graph is no longer at `version`.
  absl::StatusOr<std::int64_t> Apply(const CallContext& context, const SiteId& site, std::int64_t version,
                                     const GraphSolution& solution) const;
  // Solves the graph while nobody else changes it, for one that hardly ever rests: `solve` is given what has changed
  // since version `since`, as ReadChanges tells it, and its solution is stored as a new version, which is returned. Who
  // would change the graph waits meanwhile, so that `solve` should not take long; who reads it does not. An error of
  // `solve` is returned, and nothing is stored.
  absl::StatusOr<std::int64_t> SolveHeld(
      const CallContext& context, const SiteId& site, std::int64_t since,
      const std::function<absl::StatusOr<GraphSolution>(const GraphChanges&)>& solve) const;
  // The newest first, those before `before` (0: from the newest).
  absl::StatusOr<std::vector<GraphVersion>> ListVersions(const CallContext& context, const SiteId& site,
                                                         std::int64_t before, int limit) const;
  // The last version after `since` that an optimisation made; 0 where there is none.
  absl::StatusOr<std::int64_t> FindLastOptimization(const CallContext& context, const SiteId& site,
                                                    std::int64_t since) const;
  // As an optimisation stored them, by map. NOT_FOUND where `version` is no optimisation of the last
  // kKeptOptimizations.
  absl::StatusOr<std::vector<MapPose>> GetMapPoses(const CallContext& context, const SiteId& site,
                                                   std::int64_t version) const;
  static constexpr int kKeptOptimizations = 50;
  // Present places of those maps that have one; of all maps where `maps` is empty.
  absl::StatusOr<std::vector<MapPose>> GetPlaces(const CallContext& context, const SiteId& site,
                                                 const std::vector<MapId>& maps) const;

  // Replaces all control points of the site and raises its graph version, which is returned. NOT_FOUND where a map is
  // missing.
  absl::StatusOr<std::int64_t> SetControlPoints(const CallContext& context, const SiteId& site,
                                                const std::vector<ControlPoint>& points) const;
  absl::StatusOr<std::vector<ControlPoint>> GetControlPoints(const CallContext& context, const SiteId& site) const;

 private:
  postgres::Pool& pool_;
};

// Hears of new graph versions as they are committed. Holds one connection of the pool. Not thread-safe.
class GraphListener {
 public:
  // UNAVAILABLE where the database cannot be reached. What changed before it returns is not heard.
  static absl::StatusOr<std::unique_ptr<GraphListener>> Open(postgres::Pool& pool, const CallContext& context);
  ~GraphListener();

  struct Change {
    SiteId site;
    std::int64_t version = 0;
  };
  // Waits until something changes or the context's deadline passes (no changes, no error). UNAVAILABLE where the
  // connection is lost: open another, and look at every version again.
  absl::StatusOr<std::vector<Change>> Await(const CallContext& context);

 private:
  struct Impl;
  explicit GraphListener(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::storage
