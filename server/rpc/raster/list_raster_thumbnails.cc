// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cmath>
#include <optional>

#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/paging.h"
#include "server/rpc/raster/handlers.h"

namespace enfilade::server {
namespace {

// Pictures that are not made yet are made for so long; then the page ends.
constexpr auto kMakingTime = std::chrono::seconds(5);

void FillThumbnail(const SiteId& site, const storage::MapThumbnail& map, v1::RasterThumbnail& out) {
  const grid::Thumbnail& thumbnail = *map.thumbnail;
  const grid::GridGeometry& geometry = map.geometry;
  const double side = std::ldexp(geometry.resolution, thumbnail.zoom);
  out.set_revision(convert::NameOf(convert::RevisionName{site, map.map, map.revision}));
  out.set_resolution_m(side);
  *out.mutable_pose_map_thumbnail() = convert::ToProto(
      geometry.T_map_grid * Pose2{thumbnail.lower_left.column * side - map.lattice_min.column * geometry.resolution,
                                  thumbnail.lower_left.row * side - map.lattice_min.row * geometry.resolution, 0.0});
  out.set_width(thumbnail.width);
  out.set_height(thumbnail.height);
  out.set_cells(std::string(thumbnail.classes.begin(), thumbnail.classes.end()));
}

// Makes none if the revision has gone meanwhile.
absl::Status MakeThumbnailOf(const Services& services, const Call& call, const SiteId& site,
                             storage::MapThumbnail& map) {
  const auto revision = services.revisions.Get(call.context(), site, map.map, map.revision);
  if (absl::IsNotFound(revision.status())) return absl::OkStatus();
  ENFILADE_RETURN_IF_ERROR(revision.status());
  auto pyramid = services.raster_pyramids.Get(call.context(), *revision);
  if (absl::IsNotFound(pyramid.status())) return absl::OkStatus();
  ENFILADE_RETURN_IF_ERROR(pyramid.status());
  map.lattice_min = pyramid->lattice_min;
  map.thumbnail = std::move(pyramid->thumbnail);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::ListRasterThumbnailsResponse> ListRasterThumbnails(const Services& services, const Call& call,
                                                                      const v1::ListRasterThumbnailsRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int page_size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string after, FromPageToken(request.page_token()));
  std::optional<int> level;
  if (request.has_level()) level = request.level();
  ENFILADE_ASSIGN_OR_RETURN(auto maps,
                            services.pyramids.ListThumbnails(call.context(), site, level, MapId(after), page_size + 1));
  bool more = CutToPage(maps, page_size);
  const auto until = std::chrono::steady_clock::now() + kMakingTime;
  v1::ListRasterThumbnailsResponse response;
  MapId last;
  for (storage::MapThumbnail& map : maps) {
    if (!map.thumbnail) {
      if (std::chrono::steady_clock::now() > until) {
        more = true;
        break;
      }
      ENFILADE_RETURN_IF_ERROR(MakeThumbnailOf(services, call, site, map));
    }
    if (map.thumbnail) FillThumbnail(site, map, *response.add_thumbnails());
    last = map.map;
  }
  if (more && !last.empty()) response.set_next_page_token(ToPageToken(last.value()));
  return response;
}

}  // namespace enfilade::server
