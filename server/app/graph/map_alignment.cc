// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/map_alignment.h"

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/graph/global_pose.h"
#include "server/app/localization/call_progress.h"
#include "server/app/mapping/raster_revision.h"

namespace enfilade::server {
namespace {

constexpr double kAlignedCell = 0.05;  // m

absl::StatusOr<storage::Map> MapWithRevision(const storage::CallContext& context, const storage::MapReader& maps,
                                             const SiteId& site, const MapId& id) {
  ENFILADE_ASSIGN_OR_RETURN(storage::Map map, maps.Get(context, site, id));
  if (map.current_revision == 0) {
    return FailedPrecondition("{} has no revision yet: nothing of it has been mapped or imported", NameOf(site, id));
  }
  return map;
}

absl::StatusOr<Pose2> GuessOf(const storage::CallContext& context, SiteGraphs& graphs,
                              const MapAlignmentRequest& request) {
  if (request.T_a_b) return *request.T_a_b;
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, graphs.Get(context, request.site));
  ENFILADE_ASSIGN_OR_RETURN(const auto T_a_b, graph::FindTransform(graph->graph(), request.map_a, request.map_b));
  if (!T_a_b) {
    return FailedPrecondition("no link points join {} and {}: set pose_a_b to a guess",
                              NameOf(request.site, request.map_a), NameOf(request.site, request.map_b));
  }
  return T_a_b->T_a_b.pose;
}

absl::StatusOr<localization::AlignableMap> ReadAlignable(const storage::CallContext& context,
                                                         const storage::RevisionStore& revisions,
                                                         const storage::Map& map,
                                                         const localization::LocalizationOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision revision,
                            revisions.Get(context, map.site, map.id, map.current_revision));
  ENFILADE_ASSIGN_OR_RETURN(const grid::MapRaster raster, ReadRaster(context, revisions, revision));
  ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid grid, OnMapLattice(raster, kAlignedCell));
  return localization::AlignableMap(grid, options);
}

}  // namespace

absl::StatusOr<localization::MapAlignment> AlignStoredMaps(const storage::CallContext& context,
                                                           const MapAlignmentStores& stores, SiteGraphs& graphs,
                                                           const MapAlignmentRequest& request) {
  if (request.map_a == request.map_b) {
    return InvalidArgument("map_a and map_b are both {}: expected two maps", NameOf(request.site, request.map_a));
  }
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map a, MapWithRevision(context, stores.maps, request.site, request.map_a));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map b, MapWithRevision(context, stores.maps, request.site, request.map_b));
  if (a.level != b.level) {
    return InvalidArgument("map_a is on level {} and map_b on level {}: expected maps of one level", a.level, b.level);
  }
  ENFILADE_ASSIGN_OR_RETURN(const Pose2 T_a_b, GuessOf(context, graphs, request));
  const localization::LocalizationOptions options;
  ENFILADE_ASSIGN_OR_RETURN(const auto alignable_a, ReadAlignable(context, stores.revisions, a, options));
  ENFILADE_ASSIGN_OR_RETURN(const auto alignable_b, ReadAlignable(context, stores.revisions, b, options));
  return localization::AlignMaps(alignable_a, alignable_b, {T_a_b, request.radius, request.yaw_range}, {},
                                 [&context] { return CheckProgress(context); });
}

}  // namespace enfilade::server
