// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "core/grid/raster_pyramid.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/raster/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::GetRasterManifestResponse> GetRasterManifest(const Services& services, const Call& call,
                                                                const v1::GetRasterManifestRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::RevisionName name, convert::ParseRevisionName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision revision,
                            services.revisions.Get(call.context(), name.site, name.map, name.revision));
  ENFILADE_ASSIGN_OR_RETURN(const storage::StoredPyramid pyramid,
                            services.raster_pyramids.Get(call.context(), revision));
  const grid::GridGeometry& geometry = revision.geometry;
  const grid::CellIndex min = pyramid.lattice_min;
  v1::GetRasterManifestResponse response;
  response.set_revision(convert::NameOf(convert::RevisionName{revision.site, revision.map, revision.number}));
  response.set_resolution_m(geometry.resolution);
  *response.mutable_pose_map_tiles() = convert::ToProto(
      geometry.T_map_grid * Pose2{-min.column * geometry.resolution, -min.row * geometry.resolution, 0.0});
  response.set_first_column(min.column);
  response.set_first_row(min.row);
  response.set_width(geometry.width);
  response.set_height(geometry.height);
  for (const grid::CellClass cell : grid::ClassesOfCells()) {
    response.mutable_classes()->push_back(static_cast<char>(cell));
  }
  for (std::size_t zoom = 0; zoom < pyramid.levels.size(); ++zoom) {
    v1::RasterLevel& level = *response.add_levels();
    level.set_zoom(static_cast<std::int32_t>(zoom));
    for (const auto& [index, sha256] : pyramid.levels[zoom]) {
      v1::RasterTile& tile = *level.add_tiles();
      tile.set_row(index.row);
      tile.set_column(index.column);
      tile.set_sha256(sha256);
    }
  }
  response.set_display_only(pyramid.display_only);
  return response;
}

}  // namespace enfilade::server
