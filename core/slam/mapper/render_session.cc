// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/render_session.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/slam/mapper/map_renderer.h"
#include "core/slam/submaps/submap.h"

namespace enfilade::slam {

absl::StatusOr<grid::OccupancyGrid> RenderSession(const SlamMap& session, bool continues_map, const Pose2& T_to_map,
                                                  const SlamOptions& options) {
  MapRenderer renderer(options.resolution, LogOddsOptionsOf(options.occupancy));
  for (const auto& [id, submap] : session.submaps) {
    if (!submap.finished || (continues_map && id == 0)) continue;
    ENFILADE_ASSIGN_OR_RETURN(const SubmapContent content, DecodeSubmapContent(submap.content, options.occupancy));
    renderer.Place(id, T_to_map * submap.T_map_submap, [&]() -> const SubmapGrid& { return content.grid; });
  }
  return renderer.Render(nullptr, {});
}

}  // namespace enfilade::slam
