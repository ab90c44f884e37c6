// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/diff/map_diff.h"
#include "proto/convert/record.h"
#include "server/app/rasters/stored_revisions.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/map/named_revision.h"

namespace enfilade::server {
namespace {

constexpr int kMaxRegions = 1000;
constexpr int kUsualRegions = 100;

absl::StatusOr<grid::MapDiffOptions> DiffOptionsOf(const v1::DiffMapRevisionsRequest& request) {
  const int regions = request.max_regions() == 0 ? kUsualRegions : request.max_regions();
  if (regions < 0 || regions > kMaxRegions) {
    return InvalidArgument("max_regions is {}: expected 1 to {}, or 0 for {}", regions, kMaxRegions, kUsualRegions);
  }
  return grid::MapDiffOptions{.max_regions = static_cast<std::size_t>(regions),
                              .with_picture = request.with_picture(),
                              .with_geojson = request.with_geojson()};
}

v1::MapDiffRegion RegionMessage(const grid::MapDiffRegion& region) {
  v1::MapDiffRegion out;
  for (const Eigen::Vector2d& corner : region.box) {
    v1::Point& added = *out.mutable_box()->add_corners();
    added.set_x(corner.x());
    added.set_y(corner.y());
  }
  out.set_cells(region.cells);
  out.set_to_unknown(region.to[0]);
  out.set_to_free(region.to[1]);
  out.set_to_occupied(region.to[2]);
  return out;
}

absl::Status AddPicture(const grid::MapDiff& diff, v1::DiffMapRevisionsResponse& response) {
  ENFILADE_ASSIGN_OR_RETURN(std::string png, grid::EncodePng(diff.picture->image));
  response.set_picture(std::move(png));
  *response.mutable_pose_map_picture() = convert::ToProto(diff.picture->T_map_picture);
  response.set_picture_resolution_m(diff.resolution * diff.picture->cells_per_pixel);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::DiffMapRevisionsResponse> DiffMapRevisions(const Services& services, const Call& call,
                                                              const v1::DiffMapRevisionsRequest& request) {
  const storage::CallContext& context = call.context();
  ENFILADE_ASSIGN_OR_RETURN(const grid::MapDiffOptions options, DiffOptionsOf(request));
  ENFILADE_ASSIGN_OR_RETURN(const convert::RevisionName base,
                            ResolveRevision(services, context, "base", request.base()));
  ENFILADE_ASSIGN_OR_RETURN(const convert::RevisionName revision,
                            ResolveRevision(services, context, "revision", request.revision()));
  if (base.site != revision.site || base.map != revision.map) {
    return InvalidArgument("revision is \"{}\": expected a revision of {}, which has the base", request.revision(),
                           convert::NameOf(convert::MapName{base.site, base.map}));
  }
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision before,
                            services.revisions.Get(context, base.site, base.map, base.revision));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision after,
                            services.revisions.Get(context, revision.site, revision.map, revision.revision));
  ENFILADE_ASSIGN_OR_RETURN(const grid::MapDiff diff,
                            DiffRevisions(context, services.pyramids, services.blobs, before, after, options));
  v1::DiffMapRevisionsResponse response;
  response.set_base(convert::NameOf(base));
  response.set_revision(convert::NameOf(revision));
  response.set_resolution_m(diff.resolution);
  response.mutable_cells()->Add(diff.cells.begin(), diff.cells.end());
  response.set_region_count(diff.region_count);
  for (const grid::MapDiffRegion& region : diff.regions) *response.add_regions() = RegionMessage(region);
  if (diff.picture) ENFILADE_RETURN_IF_ERROR(AddPicture(diff, response));
  response.set_geojson(diff.geojson);
  return response;
}

}  // namespace enfilade::server
